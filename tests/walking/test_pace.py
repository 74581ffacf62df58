"""True speed against what the picture shows of it, near and far."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.cameras import horizon
from mcnlab.datasets import catalogue
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.lab.measure import measure_all
from mcnlab.statistics import Estimate
from mcnlab.tables import FRAME, SEQUENCE, WORLD_X, WORLD_Y
from mcnlab.walking import outdoors, speed


def record(*tables, frame_rate=25.0, width=2000, height=1500):
    """A recording of box tables."""
    boxes = pd.concat(tables, ignore_index=True)
    return Recording("made-up", boxes, frame_rate, width, height)


FOCAL, CAMERA = 900.0, np.array([3.0, -20.0, 6.0])


def filmed(make_boxes, tracks, *, stature=1.8, frame_rate=10.0):
    """People seen by a level camera at `CAMERA` that looks along world y: boxes and places."""
    boxes, world = [], []
    for name, (x, y, vx, vy) in tracks.items():
        time = np.arange(21) / frame_rate
        east, depth = x + vx * time - CAMERA[0], y + vy * time - CAMERA[1]
        height = FOCAL * stature / depth
        cx = (2000 - 1) / 2 + FOCAL * east / depth
        feet = 200 + FOCAL * CAMERA[2] / depth
        boxes.append(
            make_boxes(
                21,
                sequence=name,
                subject=name,
                x=cx - height / 5,
                y=feet - height,
                w=height / 2.5,
                h=height,
                cx=cx,
                cy=feet - height / 2,
            )
        )
        world.append(
            pd.DataFrame(
                {
                    SEQUENCE: name,
                    FRAME: 1 + np.arange(21),
                    WORLD_X: east + CAMERA[0],
                    WORLD_Y: depth + CAMERA[1],
                }
            )
        )
    held = record(*boxes, frame_rate=frame_rate)
    return held, pd.concat(world, ignore_index=True)


PACES = {0: 1.0, 8: -1.5, 16: 0.8, 24: 1.2, 32: -1.0}  # world y: m/s to the right
ACROSS = {f"{y}": (CAMERA[0] - v, y, v, 0.0) for y, v in PACES.items()}


@pytest.fixture(scope="module")
def scene(make_boxes):
    return filmed(make_boxes, ACROSS)


def test_the_camera_is_found_where_it_stands(scene):
    # Exact geometry: only the rounding of the direct linear transform is left.
    np.testing.assert_allclose(horizon.find_place(*scene), CAMERA[:2], atol=1e-6)


def test_pixels_fall_with_distance_and_body_heights_do_not(scene):
    recording, world = scene
    table = speed.compare_speeds(recording, world, place=CAMERA, focal_length=FOCAL)
    np.testing.assert_allclose(
        table["true_speed"], [abs(ACROSS[name][2]) for name in table[SEQUENCE]], atol=1e-9
    )
    # A second of at most 1.5 m across at 20 m or more leaves the line of sight by ±2° at most,
    # and its sine's square is what true_sideways may lose.
    np.testing.assert_allclose(table["true_sideways"], table["true_speed"], rtol=2e-3)
    depth = np.array([ACROSS[name][1] for name in table[SEQUENCE]]) - CAMERA[1]
    np.testing.assert_allclose(table["pixels"], FOCAL * table["true_speed"] / depth, rtol=1e-6)
    columns = (table["true_speed"], table["distance"], table[SEQUENCE])
    apparent = speed.distance_slope(table["pixels"], *columns)
    relative = speed.distance_slope(table["body_heights"], *columns)
    # Distance includes the camera's height, 6 m at 20 m and more: up to (6/20)²/2 = 5 % of the
    # logarithm's fall over the range, log(52/20.9), bends the slope by 0.05.
    assert apparent.value == pytest.approx(-1, abs=0.06)
    # FEET_LEAD moves the box by 0.11 body heights of 11 to 29: at most 1 % over the range.
    assert relative.value == pytest.approx(0, abs=0.02)
    assert apparent.n == relative.n == 5


def test_windows_without_true_motion_are_left_out(scene):
    recording, world = scene
    known = world[(world[SEQUENCE] == "8") & (world[FRAME] > 9)]
    table = speed.compare_speeds(recording, known, place=CAMERA, focal_length=FOCAL)
    # Of the first window, frames 1 … 10, one position is left: too few.
    assert table[[SEQUENCE, FRAME]].to_numpy().tolist() == [["8", 11]]
    with pytest.raises(DatasetError, match="no two positions"):
        speed.compare_speeds(recording, known[known[FRAME] > 99], place=CAMERA, focal_length=FOCAL)


def test_longer_and_shorter_windows_stand_in_one_table(scene):
    recording, world = scene
    table = speed.compare_speeds(
        recording, world, place=CAMERA[:2], focal_length=FOCAL, seconds=(0.5, 1, 2)
    )
    for seconds, count in {0.5: 4, 1.0: 2, 2.0: 1}.items():
        own = table[table["seconds"] == seconds]
        assert own[SEQUENCE].value_counts().to_dict() == dict.fromkeys(ACROSS, count)


@pytest.mark.parametrize("place", [(1, 2, 3, 4), (1,), (np.nan, 0), 3.0])
def test_the_place_must_be_a_place(scene, place):
    with pytest.raises(ArgumentError, match="place"):
        speed.compare_speeds(*scene, place=place, focal_length=FOCAL)


def test_a_person_twice_in_a_frame_is_refused(scene):
    recording, world = scene
    twice = pd.concat([world, world.iloc[:1]], ignore_index=True)
    with pytest.raises(DatasetError, match="twice"):
        speed.compare_speeds(recording, twice, place=CAMERA, focal_length=FOCAL)


def test_too_few_positions_show_no_camera(scene):
    recording, world = scene
    with pytest.raises(DatasetError, match="in 3 boxes with a place"):
        horizon.find_place(recording, world.iloc[:3])
    with pytest.raises(DatasetError, match="does not show where the camera stands"):
        horizon.find_place(recording, world[world[SEQUENCE] == "0"])


def test_a_camera_that_looks_straight_down_has_no_lines_of_sight(make_boxes):
    grid = np.array([(x, y) for x in range(4) for y in range(3)], float)
    boxes = make_boxes(12, x=90 + 10 * grid[:, 0], cx=100 + 10 * grid[:, 0], y=50 + 10 * grid[:, 1])
    world = pd.DataFrame({SEQUENCE: "walk", FRAME: 1 + np.arange(12)})
    world[[WORLD_X, WORLD_Y]] = np.c_[grid[:, 0], -grid[:, 1]]
    held = record(boxes.assign(h=40.0))
    with pytest.raises(DatasetError, match="parallel"):
        horizon.find_place(held, world)


# --- what the comparisons say ---------------------------------------------------------------


@given(st.floats(-3, 3), st.integers(0, 10))
def test_the_slope_is_the_power_of_distance(power, seed):
    rng = np.random.default_rng(seed)
    distance, true = rng.uniform(5, 50, 40), rng.uniform(0.6, 2, 40)
    people = np.arange(40) % 8
    found = speed.distance_slope(7 * true * distance**power, true, distance, people, draws=20)
    assert found.value == pytest.approx(power, abs=1e-6)
    assert found.low == pytest.approx(power, abs=1e-6)
    assert found.high == pytest.approx(power, abs=1e-6)
    assert found.n == 8
    assert Estimate(*found).value == found.value


def test_who_lingers_does_not_enter_the_slope():
    distance = np.array([10, 20, 30, 40.0])
    true, wild = np.ones(4), np.array([0.01, 0.0, 0.5, 0.1])
    found = speed.distance_slope(
        np.r_[1 / distance, [5, 5, 0, 5]],
        np.r_[true, wild],
        np.r_[distance, distance],
        list("abcdabcd"),
    )
    assert found.value == pytest.approx(-1)


def test_no_slope_where_the_data_have_none():
    same = np.ones(5)
    assert speed.distance_slope(same, same, 10 * same, list("abcde")) is None
    assert speed.distance_slope([1, 1], [1, 1], [10, 20], list("ab")) is None
    assert speed.distance_slope(same * 0, same, np.arange(1, 6), list("abcde")) is None
    alone = speed.distance_slope(1 / np.arange(1.0, 6), same, np.arange(1, 6), list("aaaaa"))
    assert alone.value == pytest.approx(-1)
    assert (alone.low, alone.high, alone.n) == (None, None, 1)


def test_people_seen_at_one_distance_each_still_have_an_interval():
    distance = np.array([10, 20, 40.0])
    found = speed.distance_slope(1 / distance, np.ones(3), distance, list("abc"))
    assert found[:3] == pytest.approx((-1, -1, -1))


@pytest.mark.parametrize("bad", [[1, 2, np.nan], [1, 2], [[1], [2], [3]], list("abc")])
def test_slopes_need_a_finite_number_of_each(bad):
    with pytest.raises(ArgumentError, match="distance"):
        speed.distance_slope([1, 2, 3], [1, 1, 1], bad, list("abc"))


@given(
    st.lists(
        st.tuples(st.integers(0, 6), st.sampled_from(speed.LEVELS), st.sampled_from("abc")),
        min_size=1,
        max_size=25,
    )
)
def test_misordered_pairs_are_counted(windows):
    true, level, people = map(np.array, zip(*windows, strict=True))
    below, above = true[level == 2], true[level == 3]
    found = speed.misordered(true, level, people, draws=50)
    if len(below) * len(above) == 0:
        assert found is None
        return
    wrong = [(low > high) + (low == high) / 2 for low in below for high in above]
    assert found.value == pytest.approx(np.mean(wrong))
    if found.low is not None:
        assert 0 <= found.low <= found.high <= 1
    assert found.n == len(set(people[level > 1]))


def test_levels_that_sort_people_are_never_wrong():
    true = np.arange(12.0)
    level = np.repeat([1, 2, 3], 4)
    people = np.tile(list("abcd"), 3)
    assert speed.misordered(true, level, people)[:3] == (0, 0, 0)
    assert speed.misordered(-true, level, people)[:3] == (1, 1, 1)
    assert speed.misordered(0 * true, level, people)[:3] == (0.5, 0.5, 0.5)


@given(st.lists(st.tuples(st.floats(0, 9), st.sampled_from(speed.LEVELS)), min_size=1))
def test_levels_by_another_measure_hold_as_many(windows):
    values, level = map(np.array, zip(*windows, strict=True))
    found = speed.level_like(values, level)
    assert np.bincount(found, minlength=4).tolist() == np.bincount(level, minlength=4).tolist()
    assert (np.diff(found[np.argsort(values, kind="stable")]) >= 0).all()


@pytest.mark.parametrize(("values", "level"), [([1, 2], [1]), ([np.nan], [1]), (1.0, 2)])
def test_levels_by_another_measure_need_one(values, level):
    with pytest.raises(ArgumentError, match="values"):
        speed.level_like(values, level)


# --- real people ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def tables():
    """The bundled windows."""
    return {name: outdoors.apparent_speeds(name) for name in ("pets", "tud")}


def test_bundled_windows_hold_together(tables):
    for table in tables.values():
        assert not table.duplicated(["seconds", SEQUENCE, FRAME]).any()
        assert sorted(table["seconds"].unique()) == list(outdoors.SPEED_SECONDS)
        assert np.isfinite(table.select_dtypes(float)).all(axis=None)
        # Kept to four decimals: half a unit of the last on either side.
        for whole, part in (
            ("pixels", "sideways"),
            ("body_heights", "body_heights_sideways"),
            ("true_speed", "true_sideways"),
        ):
            assert (table[part] <= table[whole] + 1.01e-4).all()
        widths = table["pixels"] / table["share"]
        steady = table["pixels"] > 5
        # share is kept to 5e-7 of at least 0.006, pixels to 5e-5 of 5.
        np.testing.assert_allclose(widths[steady], widths[steady].median(), rtol=2e-4)


def test_the_windows_of_pets_are_those_of_its_headings(tables):
    headings = outdoors.pets2009_headings()
    table = tables["pets"][tables["pets"]["seconds"] == 1]
    both = table.merge(headings, on=[SEQUENCE, FRAME], suffixes=("", "_read"))
    assert len(both) == len(table)
    # Both are kept to four decimals, and lines through the same positions.
    np.testing.assert_allclose(both["true_speed"], both["true_speed_read"], atol=1.01e-4)
    np.testing.assert_allclose(both["body_heights"], both["speed"], atol=1.01e-4)


def test_a_name_that_is_not_held_is_refused():
    with pytest.raises(ArgumentError, match="name is 'mot20'"):
        outdoors.apparent_speeds("mot20")


@pytest.mark.parametrize("name", ["pets", "tud"])
def test_the_bundled_windows_are_what_is_measured_now(recordings, name, tables):
    files, measure = {
        "pets": (catalogue.pets_files, outdoors.measure_pets2009_speeds),
        "tud": (catalogue.tud_files, outdoors.measure_tud_speeds),
    }[name]
    if not all(path.is_file() for path in files(recordings)):
        pytest.skip(f"no {name} in MCNLAB_DATA")
    pd.testing.assert_frame_equal(
        measure(recordings), tables[name], check_dtype=False, rtol=0, atol=1e-9
    )


def test_measuring_writes_the_table_of_a_street(recordings, tmp_path):
    files = catalogue.tud_files(recordings)
    if not all(path.is_file() for path in files):
        pytest.skip("no TUD-Stadtmitte in MCNLAB_DATA")
    folder = tmp_path / "data" / "motchallenge" / "TUD-Stadtmitte"
    (folder / "gt").mkdir(parents=True)
    (folder / "gt" / "gt.txt").write_bytes(files[0].read_bytes())
    (folder / "seqinfo.ini").write_bytes(files[1].read_bytes())
    written = measure_all(tmp_path / "data", tmp_path / "out")
    assert [(path.parent.name, path.name) for path in written] == [
        (catalogue.TUD, "speeds.csv.gz"),
        (catalogue.TUD, "provenance.json"),
        (catalogue.MOTCHALLENGE, "pairs.csv.gz"),
        (catalogue.MOTCHALLENGE, "provenance.json"),
    ]
    for path in written[:2]:
        assert path.read_bytes() == (catalogue.BUNDLED / catalogue.TUD / path.name).read_bytes()
