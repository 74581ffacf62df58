"""MOTChallenge folders: what is read, what is refused and where."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.datasets.motchallenge import find_sequences, read_sequence, read_sequences
from mcnlab.errors import DatasetError, McnError
from mcnlab.tables import MEASURES

INFO = "[Sequence]\nname=X\nframeRate=30\nseqLength=9\nimWidth=1920\nimHeight=1080\nimExt=.jpg\n"
MOT17 = (
    "2,7,10,20,30,40,1,1,0.5\n"
    "1,7,12,20,30,44,1,1,1\n"
    "1,3,-5,0,10,20.5,1,1,0\n"
    "1,4,50,60,10,20,1,3,1\n"  # a car
    "1,5,50,60,10,20,0,1,1\n"  # to be ignored
)
MOT15 = "1,9,499,158,31.5,75,1,-4.1,-7.3,0\n1,2,0,0,5,5,0,-1.5,2.5,0\n2,9,500,158,31,75,1,-4,-7,0\n"
PEOPLE = {  # by counting, and from the benchmark's statistics
    "mot17-02-frcnn": (62, 30, 1920, 1080),
    "mot17-04-frcnn": (83, 30, 1920, 1080),
    "pets09-s2l1": (19, 7, 768, 576),
    "tud-stadtmitte": (10, 25, 640, 480),
}


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """scratch(truth, info=…, name=…): a sequence's folder, overwritten each time."""
    root = tmp_path_factory.mktemp("motchallenge")

    def write(truth, *, info=INFO, name="SEQ-01", root=root):
        folder = root / name
        (folder / "gt").mkdir(parents=True, exist_ok=True)
        for path, content in ((folder / "gt" / "gt.txt", truth), (folder / "seqinfo.ini", info)):
            path.unlink(missing_ok=True)
            if content is not None:
                path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return folder

    return write


def test_pedestrians_are_read_person_by_person(scratch):
    recording = read_sequence(scratch(MOT17))
    assert recording.name == "seq-01"
    assert recording.frame_rate == 30
    assert (recording.frame_width, recording.frame_height) == (1920, 1080)
    boxes = recording.boxes
    assert boxes["sequence"].tolist() == boxes["subject"].tolist() == ["3", "7", "7"]
    assert boxes["frame"].tolist() == [1, 1, 2]
    # Beyond the frame as annotated; the centre is half a width and half a height away.
    assert boxes.loc[0, list(MEASURES)].tolist() == [-5, 0, 10, 20.5, 0, 10.25]
    assert boxes.loc[2, list(MEASURES)].tolist() == [10, 20, 30, 40, 25, 40]


def test_people_are_ordered_by_number_not_by_text(scratch):
    lines = [f"1,{number},1,1,5,5,1,1,1\n" for number in (10, 9, 100, 2)]
    assert read_sequence(scratch("".join(lines))).sequences == ["2", "9", "10", "100"]


def test_ten_columns_have_no_class(scratch):
    assert read_sequence(scratch(MOT15)).boxes["frame"].tolist() == [1, 2]
    unknown = "1,1,5,5,9,9,1,-1,-1,-1\n1,2,5,5,9,9,0,-1,-1,-1\n"
    assert read_sequence(scratch(unknown)).sequences == ["1"]
    # World metres may be whole, even 1: one row that is no class and visibility decides.
    assert read_sequence(scratch("1,1,5,5,9,9,1,3,1,0\n1,2,5,5,9,9,1,1,4,0\n")).sequences == [
        "1",
        "2",
    ]


def test_a_tenth_column_after_class_and_visibility_is_passed_over(scratch):
    longer = "".join(f"{line},-1\n" for line in MOT17.splitlines())
    wanted = read_sequence(scratch(MOT17)).boxes
    pd.testing.assert_frame_equal(read_sequence(scratch(longer)).boxes, wanted)


def test_classes_that_are_not_known_leave_nobody_out(scratch):
    assert read_sequence(scratch("1,1,5,5,9,9,1,-1,-1\n1,2,5,5,9,9,0,-1,-1\n")).sequences == ["1"]


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace(",", ", "),
        lambda text: text.replace(",", " , "),
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.rstrip("\n"),
        lambda text: text + "\n\n",
        lambda text: "\n" + text.replace("\n", "\n\n"),
        lambda text: text.replace("\n", " \n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("12,", "+1.2e1,"),
    ],
    ids=["space", "spaces", "crlf", "no-end", "end", "blank", "trailing", "bom", "exponent"],
)
def test_harmless_ways_of_writing_make_no_difference(scratch, change):
    wanted = read_sequence(scratch(MOT17)).boxes
    info = INFO.replace("\n", "\r\n").replace("=", " = ")
    read = read_sequence(scratch(change(MOT17), info=info)).boxes
    pd.testing.assert_frame_equal(read, wanted)


ROW = "1,1,10,20,30,40,1,1,1\n"


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "is empty"),
        ("\n\n \n", "blank lines only"),
        ("1,2,3\n", "line 1 has 3 columns"),
        ("1 1 10 20 30 40 1 1 1\n", "line 1 has 1 columns"),
        (ROW.replace(",", ";"), "line 1 has 1 columns"),
        (ROW + "2,1,10,20,30,40,1,1\n", "line 2 has 8 columns"),
        (ROW + "\n2,1,10,20,30,40,1,1,1,1\n", "line 3 has 10 columns and the first line 9"),
        (ROW + "2,1,10,20,30,40,1,1,1,1,1\n", "line 2 has 11 columns"),
        ("frame,id,left,top,width,height,conf,class,vis\n" + ROW, "line 1, column 1 holds 'frame'"),
        (ROW + "\n2,1,10,20,abc,40,1,1,1\n", "line 3, column 5 holds 'abc'"),
        (ROW + "2,1,10,20,,40,1,1,1\n", "line 2, column 5 holds ''"),
        (ROW + "2,1,10,20,nan,40,1,1,1\n", "line 2, column 5 holds 'nan'"),
        (ROW + "2,1,10,-inf,3,40,1,1,1\n", "line 2, column 4 holds '-inf'"),
        (ROW + "2,1,10,1e999,3,40,1,1,1\n", "line 2, column 4 holds 1e999"),
        (ROW + "2,1,10,True,3,40,1,1,1\n", "line 2, column 4 holds 'True'"),
        (ROW + "2,1,10,1_0,3,40,1,1,1\n", "line 2, column 4 holds '1_0'"),
        (ROW + "2,1,10,0x10,3,40,1,1,1\n", "line 2, column 4 holds '0x10'"),
        (ROW + '2,1,10,"7",3,40,1,1,1\n', "line 2, column 4 holds '\"7\"'"),
        (ROW.encode() + b"2,1,10,\xff,3,40,1,1,1\n", "line 2, column 4"),
        (ROW.encode() + b"2,1,10,\0,3,40,1,1,1\n", "line 2, column 4"),
        (ROW.encode("utf-16"), "line 1"),
        (ROW + "0,1,10,20,30,40,1,1,1\n", r"line 2, column 1 \(frame\) holds 0; frames count"),
        (ROW + "-3,1,10,20,30,40,0,1,1\n", r"column 1 \(frame\) holds -3"),
        (ROW + "2.5,1,10,20,30,40,1,1,1\n", r"column 1 \(frame\) holds 2.5; frames are whole"),
        (ROW + "3e9,1,10,20,30,40,1,1,1\n", r"column 1 \(frame\) holds 3000000000"),
        (ROW + "2,1.5,10,20,30,40,1,1,1\n", r"line 2, column 2 \(id\) holds 1.5"),
        (ROW + "2,1e17,10,20,30,40,1,1,1\n", r"column 2 \(id\)"),
        (ROW + "2,1,1e7,20,30,40,1,1,1\n", r"column 3 \(left\) holds 10000000"),
        (ROW + "2,1,1,20,0,40,1,1,1\n", r"line 2, column 5 \(width\) holds 0; a width is positive"),
        (ROW + "\n2,1,1,20,3,-4,1,1,1\n", r"line 3, column 6 \(height\) holds -4"),
        (ROW + "2,1,1,20,3,4,1,1.5,1\n", r"line 2, column 8 \(class\) holds 1.5"),
        (ROW + "\n2,1,1,2,3,4,1,1,1\n" + ROW, "line 4 has person 1 a second time in frame 1"),
        ("1,1,10,20,30,40,1,3,1\n", "no pedestrian"),
        ("1,1,10,20,30,40,0,1,1\n", "no pedestrian"),
        ("1,1,10,20,30,40,0,-1,-1,-1\n", "no pedestrian"),
    ],
)
def test_a_damaged_truth_is_refused_by_line_and_column(scratch, text, word):
    with pytest.raises(DatasetError, match=word) as caught:
        read_sequence(scratch(text))
    assert "gt.txt" in str(caught.value)


def test_rows_that_do_not_count_may_repeat_or_be_flat(scratch):
    ignored = "1,1,10,20,0,0,0,1,1\n1,2,10,20,5,5,1,8,1\n1,2,11,20,5,5,1,8,1\n"
    assert read_sequence(scratch(ROW + ignored)).sequences == ["1"]


@pytest.mark.parametrize(
    ("info", "word"),
    [
        (None, "is missing"),
        ("", "not a seqinfo.ini"),
        ("frameRate=30\n", "not a seqinfo.ini"),
        ("[Other]\nframeRate=30\n", "not a seqinfo.ini"),
        ("[Sequence]\n???\n", "not a seqinfo.ini"),
        (b"[Sequence]\nname=\xff\n", "not a seqinfo.ini"),
        (INFO.replace("frameRate=30\n", ""), "lacks the key frameRate"),
        (INFO.replace("imWidth=1920\n", ""), "lacks the key imWidth"),
        (INFO.replace("imHeight=1080\n", ""), "lacks the key imHeight"),
        (INFO.replace("=30\n", "=0\n"), "frameRate = '0'"),
        (INFO.replace("=30\n", "=-7\n"), "frameRate = '-7'"),
        (INFO.replace("=30\n", "=nan\n"), "frameRate = 'nan'"),
        (INFO.replace("=30\n", "=1e999\n"), "frameRate = '1e999'"),
        (INFO.replace("=30\n", "=thirty\n"), "frameRate = 'thirty'"),
        (INFO.replace("=30\n", "=\n"), "frameRate = ''"),
        (INFO.replace("=1920\n", "=1920.5\n"), "imWidth = '1920.5'"),
        (INFO.replace("=1080\n", "=-1080\n"), "imHeight = '-1080'"),
    ],
)
def test_a_damaged_seqinfo_is_refused_by_key(scratch, info, word):
    with pytest.raises(DatasetError, match=word) as caught:
        read_sequence(scratch(MOT17, info=info))
    assert "seqinfo.ini" in str(caught.value)


def test_a_fractional_frame_rate_is_kept(scratch):
    assert read_sequence(scratch(MOT17, info=INFO.replace("=30", "=2.5"))).frame_rate == 2.5


def test_missing_files_and_folders_in_their_place_are_refused(tmp_path):
    with pytest.raises(DatasetError, match="is missing"):
        read_sequence(tmp_path / "gone")
    (tmp_path / "X" / "gt" / "gt.txt").mkdir(parents=True)
    with pytest.raises(DatasetError, match=r"gt\.txt is not a table"):
        read_sequence(tmp_path / "X")
    for search in (find_sequences, read_sequences):
        with pytest.raises(DatasetError, match="is not a folder"):
            search(tmp_path / "gone")


cells = st.one_of(
    st.integers(-3, 9).map(str),
    st.floats(-3, 9).map(str),
    st.sampled_from(["", " ", "x", "nan", "inf", "1e400", "-0", "1e17", "١", "\0", '"', "#", "\r"]),
)


@given(st.lists(st.lists(cells, min_size=9, max_size=10), max_size=5), st.booleans())
def test_any_file_is_read_soundly_or_refused(scratch, rows, sound):
    text = "\n".join(",".join(row) for row in rows)
    try:
        recording = read_sequence(scratch(ROW * sound + text))
    except McnError:
        return
    assert np.isfinite(recording.boxes[list(MEASURES)].to_numpy()).all()
    assert len(recording.boxes) <= len(rows) + sound


def test_each_truth_is_read_once_and_what_is_left_out_is_named(scratch, tmp_path):
    for name in ("MOT17-02-SDP", "MOT17-02-DPM", "MOT17-02-FRCNN"):
        scratch(MOT17, name=name, root=tmp_path)
    scratch(MOT15, name="ADL", root=tmp_path)
    scratch("1,2\n", name="BROKEN", root=tmp_path)
    scratch(MOT17, name="HALF", info=INFO.replace("=30", "=15"), root=tmp_path)
    (tmp_path / "MOT17-01-FRCNN" / "det").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    (tmp_path / "readme.txt").write_text("not a sequence")
    names = [path.name for path in find_sequences(tmp_path)]
    assert names == ["ADL", "BROKEN", "HALF", "MOT17-02-DPM", "MOT17-02-FRCNN", "MOT17-02-SDP"]
    recordings, problems = read_sequences(tmp_path)
    # The same boxes at another frame rate are another truth.
    assert [recording.name for recording in recordings] == ["adl", "half", "mot17-02-dpm"]
    said = "\n".join(problems)
    assert len(problems) == 4
    assert "BROKEN is left out" in said
    assert "line 1 has 2 columns" in said
    assert "MOT17-01-FRCNN is left out: it has no gt/gt.txt" in said
    assert "MOT17-02-FRCNN is left out: its boxes are those of MOT17-02-DPM" in said
    assert "MOT17-02-SDP is left out: its boxes are those of MOT17-02-DPM" in said


def test_two_folders_do_not_share_a_name(scratch, tmp_path):
    scratch(MOT17, name="Seq", root=tmp_path)
    scratch(MOT15, name="seq", root=tmp_path)
    if len(find_sequences(tmp_path)) < 2:
        pytest.skip("this file system does not tell capitals apart")
    recordings, problems = read_sequences(tmp_path)
    assert [recording.name for recording in recordings] == ["seq"]
    assert "another is called seq" in problems[0]


def test_an_empty_folder_holds_no_sequences(tmp_path):
    assert find_sequences(tmp_path) == []
    assert read_sequences(tmp_path) == ([], ())


def test_the_sequences_at_hand_hold_who_the_benchmark_says(recordings):
    # Others may lie beside them; PETS09-S2L1 shows the same people as pets2009/.
    for folder in find_sequences(recordings / "motchallenge"):
        recording = read_sequence(folder)
        people, *camera = PEOPLE.get(recording.name, (None,))
        if people is not None:
            assert recording.subjects.nunique() == people
            assert [recording.frame_rate, recording.frame_width, recording.frame_height] == camera
