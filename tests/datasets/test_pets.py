"""PETS and MOTChallenge files, and true headings worked out by hand."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab.datasets.motchallenge import read_mot_world
from mcnlab.datasets.pets import read_pets, read_tsai, read_tsai_place
from mcnlab.errors import DatasetError, McnError
from mcnlab.tables import MEASURES
from mcnlab.walking.truth import true_headings

TSAI = '<Camera><Extrinsic tx="{}" ty="{}" tz="{}" rx="{}" ry="{}" rz="{}"/></Camera>'


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """scratch(name, content): a file that holds `content`, the same place each time."""
    folder = tmp_path_factory.mktemp("scratch")

    def write(name, content):
        path = folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def pets_frame(number, *people):
    objects = "".join(
        f'<object id="{who}"><box xc="{xc}" yc="{yc}" w="{w}" h="{h}"/></object>'
        for who, xc, yc, w, h in people
    )
    return f'<frame number="{number}"><objectlist>{objects}</objectlist></frame>'


def read_frames(scratch, *frames):
    path = scratch("PETS2009-S2L1.xml", f"<dataset>{''.join(frames)}</dataset>")
    return read_pets(path.parent)


def test_pets_boxes_are_read_person_by_person(scratch):
    recording = read_frames(
        scratch,
        pets_frame(0, (7, 100.0, 200.0, 20.0, 60.0), (3, 300.0, 100.0, 10.0, 30.0)),
        pets_frame(1, (7, 104.0, 202.0, 22.0, 64.0)),
    )
    assert recording.frame_rate == 7
    assert (recording.frame_width, recording.frame_height) == (768, 576)
    boxes = recording.boxes
    assert boxes["sequence"].tolist() == ["3", "7", "7"]
    assert boxes["frame"].tolist() == [0, 0, 1]
    assert boxes.loc[1, list(MEASURES)].tolist() == [90, 170, 20, 60, 100, 200]
    assert boxes.loc[2, list(MEASURES)].tolist() == [93, 170, 22, 64, 104, 202]


@pytest.mark.parametrize(
    ("frames", "word"),
    [
        ([], "no boxes"),
        ([pets_frame(0)], "no boxes"),
        ([pets_frame(0, ("who", 1, 1, 1, 1))], "not a PETS box file"),
        ([pets_frame(0, (1, "wide", 1, 1, 1))], "not a PETS box file"),
        (['<frame number="0"><object id="1"/></frame>'], "not a PETS box file"),
        (['<frame><object id="1"/></frame>'], "not a PETS box file"),
        (["<frame"], "not a PETS box file"),
        ([pets_frame(0, (1, "nan", 1, 1, 1))], "finite"),
        ([pets_frame(0, (1, 1, 1, 0, 1))], "positive"),
        ([pets_frame(0, (1, 1, 1, 1, 1), (1, 1, 1, 1, 1))], "repeated"),
    ],
    ids=["empty", "nobody", "id", "text", "no-box", "no-number", "xml", "nan", "flat", "twice"],
)
def test_malformed_pets_files_are_refused(scratch, frames, word):
    with pytest.raises(McnError, match=word):
        read_frames(scratch, *frames)


def test_an_unknown_encoding_is_refused(scratch):
    header = '<?xml version="1.0" encoding="martian"?>'
    with pytest.raises(DatasetError, match="not a PETS box file"):
        read_pets(scratch("PETS2009-S2L1.xml", header + "<dataset/>").parent)
    with pytest.raises(DatasetError, match="not a Tsai calibration"):
        read_tsai_place(scratch("View_001.xml", header + TSAI.format(0, 0, 0, 0, 0, 0)))


@pytest.mark.parametrize("read", [read_pets, read_mot_world, read_tsai_place])
def test_missing_files_and_folders_in_their_place_are_refused(tmp_path, read):
    with pytest.raises(DatasetError, match="missing"):
        read(tmp_path / "gone")
    (tmp_path / "PETS2009-S2L1.xml").mkdir()
    with pytest.raises(DatasetError):
        read(tmp_path)


def test_world_positions_are_read_with_frames_from_zero(scratch):
    path = scratch("gt.txt", "1,3,10,20,5,9,1,-4.5,2.25,0\n2,3,11,20,5,9,1,-4.25,2.5,0\n")
    world = read_mot_world(path)
    assert world.to_dict("list") == {
        "sequence": ["3", "3"],
        "frame": [0, 1],
        "world_x": [-4.5, -4.25],
        "world_y": [2.25, 2.5],
    }


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\n\n",
        "frame,id\n",
        "1,3,10,20,5,9,1\n",
        "1,3,10,20,5,9,1,2,3,0\n1,3,10\n",
        "1,3,10,20,5,9,1,nan,3,0\n",
        "1,3,10,20,5,9,1,inf,3,0\n",
        "1.5,3,10,20,5,9,1,2,3,0\n",
        "1,3.5,10,20,5,9,1,2,3,0\n",
        "1e300,3,10,20,5,9,1,2,3,0\n",
        "1,3,10,20,5,9,1,2,3,0\n1,3,10,20,5,9,1,2,4,0\n",
    ],
    ids=["empty", "blank", "text", "short", "ragged", "nan", "inf", "frame", "id", "huge", "twice"],
)
def test_malformed_world_positions_are_refused(scratch, text):
    with pytest.raises(DatasetError, match=r"gt\.txt"):
        read_mot_world(scratch("gt.txt", text))


def test_a_camera_stands_where_its_calibration_is_undone(scratch):
    # Unturned, a camera at p sees the world shifted by −p.
    place = read_tsai_place(scratch("v.xml", TSAI.format(-1000, -2000, 3000, 0, 0, 0)))
    assert place.tolist() == [1, 2, -3]
    # Turned by 90° about x: camera y = −z world, camera z = y world, so a camera at
    # (1, 2, 7) has the shift (−1, 7, −2).
    turned = TSAI.format(-1000, 7000, -2000, np.pi / 2, 0, 0)
    assert read_tsai_place(scratch("v.xml", turned)) == pytest.approx([1, 2, 7])


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-50, 50)] * 3))
def test_any_turn_of_the_camera_is_undone(scratch, turn, place):
    (cos_x, cos_y, cos_z), (sin_x, sin_y, sin_z) = np.cos(turn), np.sin(turn)
    # Tsai's rotation, written out: Rz·Ry·Rx.
    rotation = np.array(
        [
            [
                cos_y * cos_z,
                cos_z * sin_x * sin_y - cos_x * sin_z,
                sin_x * sin_z + cos_x * cos_z * sin_y,
            ],
            [
                cos_y * sin_z,
                sin_x * sin_y * sin_z + cos_x * cos_z,
                cos_x * sin_y * sin_z - cos_z * sin_x,
            ],
            [-sin_y, cos_y * sin_x, cos_x * cos_y],
        ]
    )
    shift = -rotation @ (1000 * np.array(place))
    found = read_tsai_place(scratch("v.xml", TSAI.format(*map(float, shift), *turn)))
    assert found == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<Camera/>",
        "<Camera><Extrinsic tx='1'/></Camera>",
        TSAI.format("far", 0, 0, 0, 0, 0),
        TSAI.format("nan", 0, 0, 0, 0, 0),
        TSAI.format(0, 0, 0, "inf", 0, 0),
        TSAI[:-5],
    ],
    ids=["empty", "none", "part", "text", "nan", "inf", "cut"],
)
def test_malformed_calibrations_are_refused(scratch, text):
    with pytest.raises(DatasetError, match=r"v\.xml is not a Tsai calibration"):
        read_tsai_place(scratch("v.xml", text))


WHOLE = (
    '<Camera><Geometry dpx="{}" dpy="0.005"/><Intrinsic focal="5" kappa1="0.001" cx="384" '
    'cy="288" sx="1"/><Extrinsic tx="0" ty="0" tz="9000" rx="3" ry="0.1" rz="{}"/></Camera>'
)


def test_a_whole_calibration_is_a_camera(scratch):
    path = scratch("v.xml", WHOLE.format(0.005, 0.2))
    camera = read_tsai(path)
    # 5 mm over pixels of 0.005 mm; κ is 0.001/mm² and so 0.001·5² where the focal length is 1.
    assert camera.intrinsics.tolist() == [[1000, 0, 384], [0, 1000, 288], [0, 0, 1]]
    assert camera.distortion == pytest.approx(0.025)
    assert (camera.frame_width, camera.frame_height) == (768, 576)
    smaller = read_tsai(path, frame_width=480)
    assert smaller.intrinsics.tolist() == [[625, 0, 240], [0, 625, 180], [0, 0, 1]]
    assert (smaller.frame_width, smaller.frame_height) == (480, 360)
    assert camera.centre == pytest.approx(read_tsai_place(path))


@pytest.mark.parametrize("cells", [(0, 0), (-1, 0), ("nan", 0), ("far", 0), (0.005, "inf")])
def test_an_impossible_calibration_is_refused(scratch, cells):
    with pytest.raises(DatasetError, match=r"v\.xml is not a Tsai calibration"):
        read_tsai(scratch("v.xml", WHOLE.format(*cells)))
    with pytest.raises(DatasetError, match="needs Geometry dpx, dpy; Intrinsic"):
        read_tsai(scratch("v.xml", TSAI.format(0, 0, 0, 0, 0, 0)))
    with pytest.raises(DatasetError, match="missing"):
        read_tsai(scratch("v.xml", "").parent / "none.xml")


def world_of(x, y, vx, vy, n=7, rate=7.0, name="3"):
    time = (np.arange(n) - (n - 1) / 2) / rate
    return pd.DataFrame(
        {
            "sequence": name,
            "frame": np.arange(10, 10 + n),
            "world_x": x + vx * time,
            "world_y": y + vy * time,
        }
    )


WINDOW = pd.DataFrame({"sequence": ["3"], "frame": [10]}, index=[42])
LENS = {"window": 7, "frame_rate": 7.0}


@pytest.mark.parametrize(
    ("position", "velocity", "sight"),
    [
        # Seen from above with y to the north, the camera at (2, 1).
        ((2, 11), (0, 1), 0),  # north of the camera, going north: away
        ((2, 11), (1, 0), 90),  # going east: to the right
        ((2, 11), (0, -1), 180),  # toward
        ((2, 11), (-1, 0), 270),  # to the left
        ((12, 1), (1, 0), 0),  # east of the camera, going east: away
        ((12, 1), (0, 1), 270),  # going north: to the left
        ((12, 1), (0, -1), 90),
        ((12, 11), (1, 0), 45),  # north-east, going east: away to the right
        ((-8, 11), (1, 0), 135),  # north-west, going east: toward, to the right
        ((2, -9), (0, 1), 180),  # south of the camera, going north
    ],
)
def test_a_true_heading_is_taken_against_the_line_of_sight(position, velocity, sight):
    world = world_of(*position, *(1.5 * np.array(velocity)))
    truth = true_headings(world, WINDOW, place=[2, 1, 7], **LENS)
    assert truth.index.tolist() == [42]
    turn = (truth.loc[42, "true_sight"] - sight + 180) % 360 - 180
    assert turn == pytest.approx(0, abs=1e-9)
    assert truth.loc[42, "true_speed"] == pytest.approx(1.5)


def test_positions_that_are_missing_do_not_change_a_steady_walk():
    world = world_of(2, 11, 1.0, 0.0)
    whole = true_headings(world, WINDOW, place=[2, 1], **LENS)
    # The first and the last gone: the mean place stays.
    part = true_headings(world.iloc[1:-1], WINDOW, place=[2, 1], **LENS)
    assert part.to_numpy() == pytest.approx(whole.to_numpy())


def test_a_window_without_two_positions_is_named():
    with pytest.raises(DatasetError, match="no two positions of '3'"):
        true_headings(world_of(2, 11, 1, 0).iloc[:1], WINDOW, place=[2, 1], **LENS)
    with pytest.raises(DatasetError, match="no two positions of '3'"):
        true_headings(world_of(2, 11, 1, 0, name="4"), WINDOW, place=[2, 1], **LENS)


def test_a_world_table_that_lacks_a_column_or_repeats_a_row_is_refused():
    world = world_of(2, 11, 1, 0)
    with pytest.raises(McnError, match="world_y"):
        true_headings(world.drop(columns="world_y"), WINDOW, place=[2, 1], **LENS)
    with pytest.raises(McnError, match="world"):
        true_headings(pd.concat([world, world[:1]]), WINDOW, place=[2, 1], **LENS)


@given(
    st.one_of(
        st.binary(max_size=200),
        st.text('<>/="frameobjctidxywhn01234 .', max_size=80).map(
            lambda inside: f'<d><frame number="1">{inside}</frame></d>'.encode()
        ),
        st.tuples(*[st.text("0123456789-.einfna", max_size=12)] * 5).map(
            lambda cells: f"<d>{pets_frame(cells[0], (1, *cells[1:]))}</d>".encode()
        ),
    )
)
@settings(max_examples=300)
def test_any_bytes_are_boxes_or_a_clear_error(scratch, data):
    try:
        recording = read_pets(scratch("PETS2009-S2L1.xml", data).parent)
    except McnError:
        return
    assert np.isfinite(recording.boxes[list(MEASURES)].to_numpy()).all()


@given(
    st.one_of(
        st.binary(max_size=200),
        st.lists(st.sampled_from(["1", "2", "3.5", "-1", "nan", "x", ""]), max_size=24).map(
            lambda cells: ",".join(cells).encode()
        ),
        st.text("0123456789-.e,\n #", max_size=80).map(str.encode),
    )
)
@settings(max_examples=300)
def test_any_bytes_are_positions_or_a_clear_error(scratch, data):
    try:
        world = read_mot_world(scratch("gt.txt", data))
    except McnError:
        return
    assert np.isfinite(world[["world_x", "world_y"]].to_numpy()).all()
    assert not world.duplicated(["sequence", "frame"]).any()
