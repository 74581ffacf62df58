"""Trajectory files: units, axes and time read rightly, damage named."""

import numpy as np
import pytest

from mcnlab.datasets.trajectories import (
    EDINBURGH_PIXEL,
    find_scenes,
    read_edinburgh,
    read_eth_ucy,
    read_juelich,
    read_scenes,
)
from mcnlab.errors import DatasetError
from mcnlab.tables import FRAME, TRACE, X, Y

JUELICH = "2 7 100 -250.5 170\n1 5 0 0 180\n1 6 10 50 180\n2 8 110 -200 170\n"
OBSMAT = """ 1 4 1.5 0 -2 0 0 0
 11 4 2.0 0 -2 0 0 0
 11 9 0.0 0 3 0 0 0
 31 9 0.0 0 4 0 0 0
 21 9 0.0 0 3.5 0 0 0
"""


def track(number, rows):
    return f"TRACK.R{number}=[" + ";".join(f"[{x} {y} {t}]" for x, y, t in rows) + "];\n"


def along(n, *, start=0, frame=100, step=4):
    """A walk of n frames to the right along row 79."""
    return [(start + step * number, 79, frame + number) for number in range(n)]


@pytest.fixture
def write(tmp_path):
    def write(name, text):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    return write


def rows_of(scene, name):
    table = scene.traces[scene.traces[TRACE] == name]
    return [tuple(row) for row in table[[FRAME, X, Y]].to_numpy().round(6).tolist()]


def test_juelich_is_centimetres_at_16_frames_a_second(write):
    scene = read_juelich(write("runs/uo-100-180-180.txt", JUELICH))
    assert (scene.name, scene.frame_rate, scene.walkers) == ("uo-100-180-180", 16, ["1", "2"])
    assert rows_of(scene, "1") == [(5, 0, 0), (6, 0.1, 0.5)]
    assert rows_of(scene, "2") == [(7, 1, -2.505), (8, 1.1, -2.0)]
    assert scene.area == (-1.0, -3.6, 2.1, 1.5)  # a metre's margin, to whole decimetres
    assert len(scene.walls) == 0


def test_comments_in_a_juelich_file_are_passed_over(write):
    scene = read_juelich(write("run.txt", "# id frame x y z\n" + JUELICH))
    assert len(scene.traces) == 4


def test_both_cameras_together_are_named_after_the_run(write):
    assert read_juelich(write("ug-100-015_combined_MB.txt", JUELICH)).name == "ug-100-015"


def test_eth_frames_count_annotated_steps(write):
    scene = read_eth_ucy(write("seq_hotel/obsmat.txt", OBSMAT).parent)
    assert (scene.name, scene.frame_rate) == ("seq_hotel", 2.5)
    assert rows_of(scene, "4") == [(0, 1.5, -2), (1, 2.0, -2)]
    assert rows_of(scene, "9") == [(1, 0, 3), (2, 0, 3.5), (3, 0, 4)]


def test_an_obsmat_can_be_named_itself(write):
    assert read_eth_ucy(write("zara01/obsmat.txt", OBSMAT)).name == "zara01"


def test_edinburgh_is_pixels_from_the_top(write):
    text = "% Total number\n\nProperties.R7=[1 2.5];\n " + track(7, along(10))
    scene = read_edinburgh(write("tracks.01Aug.txt", text))
    assert (scene.name, scene.frame_rate, scene.problems) == ("edinburgh-01aug", 9, ())
    # Row 79 from the top of 480 is 400 above the lowest.
    assert scene.traces[Y].to_numpy() == pytest.approx(np.full(10, 400 * EDINBURGH_PIXEL))
    assert scene.traces[X].to_numpy() == pytest.approx(4 * np.arange(10) * 0.0247)
    assert scene.traces[FRAME].tolist() == list(range(100, 110))


def test_a_track_that_jumps_is_cut(write):
    # 8 m/s at 9 frames a second are 36 pixels a frame.
    rows = along(12) + along(12, start=300, frame=112)
    scene = read_edinburgh(write("tracks.x.txt", track(3, rows)))
    assert scene.walkers == ["3", "3-1"]
    assert scene.traces.groupby(TRACE).size().tolist() == [12, 12]
    assert "1 cuts" in scene.problems[0]


def test_a_gap_allows_the_distance_that_one_can_walk_in_it(write):
    rows = along(12) + along(12, start=300, frame=150)  # 256 pixels in 39 frames
    assert read_edinburgh(write("tracks.x.txt", track(3, rows))).walkers == ["3"]


def test_what_lasts_less_than_a_second_is_dropped_and_counted(write):
    text = track(1, along(9)) + track(2, along(10)) + track(3, along(1))
    scene = read_edinburgh(write("tracks.x.txt", text))
    assert scene.walkers == ["2"]
    assert "2 tracks left out: shorter than 1 s" in scene.problems[0]


def test_of_two_detections_in_a_frame_the_first_counts(write):
    rows = [*along(12), (50, 50, 111)]
    scene = read_edinburgh(write("tracks.x.txt", track(1, rows)))
    assert scene.traces[X].iloc[-1] == pytest.approx(44 * EDINBURGH_PIXEL)
    assert "1 detections left out" in scene.problems[0]


def test_a_track_that_breaks_off_is_counted(write):
    text = track(1, along(12)) + "TRACK.R2=[[1 2 3];[4 5"
    scene = read_edinburgh(write("tracks.x.txt", text))
    assert scene.walkers == ["1"]
    assert "1 tracks left out: empty or broken off" in scene.problems[0]


def test_a_folder_gives_whichever_datasets_it_holds(write, tmp_path):
    assert find_scenes(tmp_path) == []
    write("eth-ucy/zara01/obsmat.txt", OBSMAT)
    write("juelich-corridor/runs/BO-360-050-050.txt", JUELICH)
    run = "juelich-corridor/two-cameras/ug-100-015/ug-100-015"
    write(f"{run}_combined_MB.txt", JUELICH)
    write(f"{run}_cam1_MB.txt", JUELICH)
    write("edinburgh/tracks.01Aug.txt", track(1, along(12)))
    names = ["bo-360-050-050", "ug-100-015", "zara01", "edinburgh-01aug"]
    assert [file.name for file in find_scenes(tmp_path)] == names
    scenes, problems = read_scenes(tmp_path)
    assert [scene.name for scene in scenes] == names
    assert problems == ()


def test_a_damaged_file_is_left_out_and_named(write, tmp_path):
    write("juelich-corridor/runs/a.txt", JUELICH)
    write("juelich-corridor/runs/b.txt", JUELICH.replace("50 180", "nan 180"))
    scenes, problems = read_scenes(tmp_path)
    assert [scene.name for scene in scenes] == ["a"]
    assert len(problems) == 1
    assert problems[0].startswith("b is left out")


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="not a folder"):
        find_scenes(tmp_path / "nowhere")


@pytest.mark.parametrize("read", [read_juelich, read_eth_ucy, read_edinburgh])
def test_a_missing_file_is_refused(read, tmp_path):
    with pytest.raises(DatasetError, match="missing"):
        read(tmp_path / "obsmat.txt")


@pytest.mark.parametrize("read", [read_juelich, read_eth_ucy, read_edinburgh])
@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00\x01", b"one two three"])
def test_a_file_of_something_else_is_refused(read, content, tmp_path):
    path = tmp_path / "obsmat.txt"
    path.write_bytes(content)
    with pytest.raises(DatasetError, match=r"obsmat\.txt"):
        read(path)


@pytest.mark.parametrize("read", [read_juelich, read_edinburgh])
def test_a_folder_instead_of_a_file_is_refused(read, tmp_path):
    with pytest.raises(DatasetError, match="restore"):
        read(tmp_path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (JUELICH.replace(" 170", ""), "line . has 4 columns"),
        ("1 5 0 0\n1 6 0 0\n", "line 1 has 4 columns; the format has 5"),
        (JUELICH + "3 1 0 0\n", "line 5 has 4 columns"),
        (JUELICH + "3 1 0 0 170 9\n", "line 5 has 6 columns"),
        (JUELICH + "3 1 x 0 170\n", "line 5, column 3 holds 'x'"),
        (JUELICH + "3 1 nan 0 170\n", "line 5, column 3 holds 'nan'"),
        (JUELICH + "3 1 inf 0 170\n", "line 5, column 3 holds 'inf'"),
        (JUELICH + "3 1 1e30 0 170\n", "kilometres"),
        (JUELICH + "3 1e300 0 0 170\n", "whole"),
        (JUELICH + "3.5 1 0 0 170\n", "whole"),
        (JUELICH + "1 5.5 0 0 170\n", "whole"),
        (JUELICH + "1 5 9 9 170\n", "person 1 twice in frame 5"),
        ("# nobody\n", "blank lines only"),
    ],
)
def test_a_damaged_juelich_file_is_refused(text, words, write):
    with pytest.raises(DatasetError, match=words):
        read_juelich(write("run.txt", text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (JUELICH, "5 columns; the format has 8"),
        (OBSMAT + " 41 9 nan 0 5 0 0 0\n", "line 6, column 3 holds 'nan'"),
        (OBSMAT + " 31 9 0 0 5 0 0 0\n", "person 9 twice in frame 31"),
        (OBSMAT + " 36 9 0 0 5 0 0 0\n", "10 frames apart, but not frame 36"),
        ("1 1 0 0 0 0 0 0\n1 2 0 0 0 0 0 0\n", "nobody for two frames"),
    ],
)
def test_a_damaged_obsmat_is_refused(text, words, write):
    with pytest.raises(DatasetError, match=words):
        read_eth_ucy(write("zara01/obsmat.txt", text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Properties.R1=[1 2 3];\n", "no TRACK"),
        ("TRACK.R1=[];\n", "no TRACK"),
        ("TRACK.R1=[[1 2];[3 4]];\n", "three numbers"),
        ("TRACK.R1=[[1 2 3];[3 4]];\n", "three numbers"),
        ("TRACK.R1=[[1 2 3 4 5 6]];\n", "three numbers"),
        ("TRACK.R1=[[1 2 x]];\n", "three numbers"),
        ("TRACK.R1=[[1 nan 3]];\n", "a number is nan in row 0"),
        ("TRACK.R1=[[1 2 3.5]];\n", "whole"),
        (track(1, along(12)) + track(1, along(12)), "number twice"),
        (track(1, along(5)), "no track of 1 s"),
    ],
)
def test_a_damaged_edinburgh_file_is_refused(text, words, write):
    with pytest.raises(DatasetError, match=words):
        read_edinburgh(write("tracks.x.txt", text))


# People a run, as the experiments' documentation counts them.
PEOPLE = {"uo-100-180-180": 121, "seq_hotel": 390, "zara01": 148}


def test_real_scenes_hold_people_who_walk(recordings):
    scenes, problems = read_scenes(recordings)
    assert problems == ()
    assert scenes
    for scene in scenes:
        assert len(scene.walkers) == PEOPLE.get(scene.name, len(scene.walkers))
        steps = scene.traces.groupby(TRACE)[[FRAME, X, Y]].diff().dropna()
        speed = np.hypot(steps[X], steps[Y]) / steps[FRAME] * scene.frame_rate
        # People walk at up to 1.5 m/s or so, stand, and never fly: units and rates are right.
        assert 0.3 < speed.median() < 1.8, scene.name
        assert speed.max() <= 8.0, scene.name


def test_the_steps_of_eth_and_ucy_last_as_long_as_their_velocities_say(recordings):
    for folder in sorted((recordings / "eth-ucy").glob("*/")):
        scene = read_eth_ucy(folder)
        values = np.loadtxt(folder / "obsmat.txt")
        steps = scene.traces.groupby(TRACE)[[FRAME, X, Y]].diff().dropna()
        # Velocities are in m/s: the medians of steps and speeds must agree; a rate wrong by
        # the nearest whole factor would be off by half.
        metres = np.median(np.hypot(steps[X], steps[Y]) / steps[FRAME])
        speed = np.median(np.hypot(values[:, 5], values[:, 7]))
        assert metres * scene.frame_rate == pytest.approx(speed, rel=0.05)
