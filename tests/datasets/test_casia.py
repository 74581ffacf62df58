"""CASIA A files: whole ones are read, damaged ones are refused by name, and never half-read."""

import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mcnlab.datasets.casia import (
    check_png,
    find_sequences,
    numbering_faults,
    read_directions,
    read_silhouette,
)
from mcnlab.errors import DatasetError, McnError
from mcnlab.vision.recordings import measure_casia_a


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """scratch(data): a file that holds `data`, the same place each time."""
    path = tmp_path_factory.mktemp("scratch") / "abc-00_1-001.png"

    def write(data):
        path.write_bytes(data)
        return path

    return write


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(header, *rest):
    return b"\x89PNG\r\n\x1a\n" + b"".join([chunk(b"IHDR", header), *rest, chunk(b"IEND", b"")])


HEADER = struct.pack(">IIBBBBB", 352, 240, 8, 0, 0, 0, 0)  # 8-bit grey
ROWS = zlib.compress(bytes(240 * 353))  # a filter byte and 352 pixels a row


def test_a_silhouette_comes_back_pixel_by_pixel(scratch, draw_walker, encode_png):
    mask = draw_walker()
    assert (read_silhouette(scratch(encode_png(mask))) == mask).all()
    assert not read_silhouette(scratch(png(HEADER, chunk(b"IDAT", ROWS)))).any()


@given(st.data())
@settings(max_examples=300)
def test_no_flipped_bit_goes_unseen(draw_walker, encode_png, data):
    whole = encode_png(draw_walker())
    at = data.draw(st.integers(0, len(whole) - 1))
    damaged = bytearray(whole)
    damaged[at] ^= data.draw(st.integers(1, 255))
    with pytest.raises(DatasetError, match=r"walk\.png is"):
        check_png(bytes(damaged), name="walk.png")


def test_no_flipped_byte_goes_unseen_at_any_position(draw_walker, encode_png):
    whole = encode_png(draw_walker())
    for at in range(len(whole)):
        with pytest.raises(DatasetError):
            check_png(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :], name="walk.png")


def test_no_truncation_goes_unseen_at_any_position(draw_walker, encode_png):
    whole = encode_png(draw_walker())
    assert check_png(whole, name="walk.png") == (352, 240)
    for length in range(len(whole)):
        with pytest.raises(DatasetError, match="not a PNG" if length < 8 else f"after {length} "):
            check_png(whole[:length], name="walk.png")


@given(st.binary(max_size=200), st.booleans())
@example(b"\x00\x00\x00\x00IEND" + struct.pack(">I", zlib.crc32(b"IEND")), True)
@example(b"\xff\xff\xff\xffIHDR\x00\x00\x00\x00", True)
def test_any_bytes_are_a_size_or_a_clear_error(scratch, data, signed):
    data = b"\x89PNG\r\n\x1a\n" + data if signed else data
    for read in (lambda: check_png(data, name="walk.png"), lambda: read_silhouette(scratch(data))):
        with pytest.raises(DatasetError, match="png"):
            read()


@given(st.binary(max_size=13), st.lists(st.binary(max_size=60), max_size=2))
def test_any_sound_chunks_are_an_image_or_a_clear_error(scratch, header, parts):
    path = scratch(png(header + HEADER[len(header) :], *(chunk(b"IDAT", part) for part in parts)))
    with pytest.raises(DatasetError):  # none of so few bytes is a whole image
        read_silhouette(path)


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"", "not a PNG"),
        (b"GIF89a and so on", "not a PNG"),
        (png(HEADER[:4], chunk(b"IDAT", ROWS)), "no header"),
        (png(HEADER), "cannot be decoded"),
        (png(HEADER, chunk(b"IDAT", ROWS[:40])), "cannot be decoded"),
        (png(struct.pack(">IIBBBBB", 240, 352, 8, 0, 0, 0, 0)), "240×352 pixels, not 352×240"),
    ],
    ids=["empty", "gif", "no-header", "no-pixels", "few-pixels", "size"],
)
def test_what_is_no_silhouette_is_refused(scratch, data, word):
    with pytest.raises(DatasetError, match=word):
        read_silhouette(scratch(data))


def test_a_grey_image_is_refused(scratch, draw_walker, encode_png):
    mask = cv2.GaussianBlur(draw_walker(), (5, 5), 0)
    grey = np.count_nonzero((mask > 0) & (mask < 255))
    with pytest.raises(DatasetError, match=f"has {grey} pixels that are neither 0 nor 255"):
        read_silhouette(scratch(encode_png(mask)))


def test_a_wrong_checksum_is_told_from_a_truncation(scratch, draw_walker, encode_png):
    whole = bytearray(encode_png(draw_walker()))
    whole[29] ^= 1  # the header's own checksum
    with pytest.raises(DatasetError, match="checksum"):
        read_silhouette(scratch(bytes(whole)))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DatasetError, match=r"gone\.png cannot be read"):
        read_silhouette(tmp_path / "gone.png")


def test_sequences_are_found_in_order(casia_folder):
    (casia_folder / "silhouettes" / "abc" / "90_1").mkdir()  # empty: no sequence
    (casia_folder / "silhouettes" / "notes.txt").write_text("not a subject")
    found = find_sequences(casia_folder)
    assert [walk.name for walk in found] == ["abc-00_1", "abc-45_1", "xyz-00_1", "xyz-45_1"]
    assert [walk.subject for walk in found] == ["abc", "abc", "xyz", "xyz"]
    assert [path.name[-7:-4] for path in found[0].paths] == [f"{k:03d}" for k in range(1, 13)]
    assert found[0].read().shape == (12, 240, 352)


def test_frames_are_ordered_by_number_not_by_name(tmp_path, draw_walker, encode_png):
    folder = tmp_path / "silhouettes" / "abc" / "00_1"
    folder.mkdir(parents=True)
    for number in range(1, 12):
        mask = draw_walker(left=10 * number)
        (folder / f"abc-00_1-{number}.png").write_bytes(encode_png(mask))
    masks = find_sequences(tmp_path)[0].read()
    left = [np.flatnonzero(mask.any(axis=0))[0] for mask in masks]
    assert left == [10 * number for number in range(1, 12)]


@pytest.mark.parametrize("folders", [[], ["silhouettes"], ["silhouettes/abc/00_1"]])
def test_a_folder_without_silhouettes_is_refused(tmp_path, folders):
    for folder in folders:
        (tmp_path / folder).mkdir(parents=True)
    with pytest.raises(DatasetError, match="silhouettes"):
        find_sequences(tmp_path)


def test_missing_frames_are_named_one_by_one(casia_folder):
    walk = find_sequences(casia_folder)[0]
    for number in (1, 4, 7):
        walk.paths[number - 1].unlink()
    with pytest.raises(DatasetError, match=r"abc-00_1: frame\(s\) 1, 4, 7 missing"):
        find_sequences(casia_folder)[0].read()


def test_every_fault_of_a_sequence_is_named(casia_folder):
    walk = find_sequences(casia_folder)[0]
    walk.paths[1].write_bytes(b"no image")
    walk.paths[2].write_bytes(walk.paths[2].read_bytes()[:-5])
    walk.paths[5].unlink()
    walk.paths[6].rename(walk.paths[6].with_name("abc-00_1-last.png"))
    with pytest.raises(DatasetError) as caught:
        find_sequences(casia_folder)[0].read()
    for fault in (
        "002.png is not a PNG",
        "003.png is truncated",
        "6, 7 missing",
        "last.png has no",
    ):
        assert fault in str(caught.value)


@given(st.sets(st.integers(1, 40), min_size=1, max_size=40))
def test_numbering_faults_are_the_numbers_left_out(tmp_path_factory, numbers):
    paths = [tmp_path_factory.getbasetemp() / f"abc-00_1-{number:03d}.png" for number in numbers]
    missing = sorted(set(range(1, max(numbers) + 1)) - numbers)
    faults = list(numbering_faults(paths))
    listed = ", ".join(map(str, missing[:8]))
    assert faults == ([f"frame(s) {listed} missing."] if missing else [])


def test_a_frame_number_that_occurs_twice_is_a_fault(tmp_path):
    paths = [tmp_path / "abc-00_1-1.png", tmp_path / "abc-00_1-001.png"]
    assert list(numbering_faults(paths)) == ["a frame number occurs twice."]


@pytest.mark.parametrize("harm", ["truncate", "unlink", "swap"])
def test_a_damaged_sequence_is_left_out_whole_and_named(casia_folder, harm):
    path = find_sequences(casia_folder)[1].paths[4]
    if harm == "truncate":
        path.write_bytes(path.read_bytes()[:100])
    elif harm == "unlink":
        path.unlink()
    else:
        path.write_bytes(b"\x00" * 100)
    recording = measure_casia_a(casia_folder, n_jobs=1)
    assert recording.sequences == ["abc-00_1", "xyz-00_1", "xyz-45_1"]
    assert len(recording.boxes) == 3 * 12
    (problem,) = recording.problems
    assert "abc-45_1" in problem
    assert "5" in problem if harm == "unlink" else path.name in problem


def test_labels_without_silhouettes_are_let_be_but_not_the_reverse(casia_folder):
    labels = casia_folder / "directions.csv"
    labels.write_text(labels.read_text() + "far,00_1,3\n")
    assert "far-00_1" not in measure_casia_a(casia_folder, n_jobs=1).directions
    labels.write_text("subject,sequence,direction\nabc,00_1,7\n")
    with pytest.raises(DatasetError, match="lacks a label for abc-45_1, xyz-00_1, xyz-45_1"):
        measure_casia_a(casia_folder, n_jobs=1)


@pytest.mark.parametrize("direction", [0, 9, -1])
def test_a_direction_beyond_eight_is_refused(casia_folder, direction):
    labels = casia_folder / "directions.csv"
    labels.write_text(labels.read_text().replace("abc,45_1,6", f"abc,45_1,{direction}"))
    with pytest.raises(DatasetError, match=f"'abc-45_1' the direction .*{direction}.*1 to 8"):
        measure_casia_a(casia_folder, n_jobs=1)


def test_labels_are_read_with_and_without_a_subject_column(tmp_path):
    path = tmp_path / "directions.csv"
    path.write_text("subject,sequence,direction\nabc,00_1,7\n")
    assert read_directions(path).to_dict() == {"abc-00_1": 7}
    path.write_text("sequence,direction\nabc-00_1,7\n")
    assert read_directions(path).to_dict() == {"abc-00_1": 7}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "sequence\nabc\n",
        "sequence,direction\nabc,away\n",
        "sequence,direction\nabc,\n",
        "sequence,direction\nabc,2.5\n",
        "sequence,direction\nabc,99999999999999999999\n",
        'sequence,direction\n"abc,1\n',
    ],
    ids=["empty", "column", "text", "none", "fraction", "huge", "quote"],
)
def test_a_table_without_labels_is_refused(tmp_path, text):
    path = tmp_path / "directions.csv"
    path.write_text(text)
    with pytest.raises(DatasetError, match=r"directions\.csv is not a table"):
        read_directions(path)


def test_a_label_file_that_is_missing_or_a_folder_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="missing"):
        read_directions(tmp_path / "directions.csv")
    with pytest.raises(DatasetError, match="directions"):
        (tmp_path / "directions").mkdir()
        read_directions(tmp_path / "directions")


@given(
    st.one_of(
        st.binary(max_size=100),
        st.binary(max_size=60).map(lambda tail: b"sequence,direction\nabc," + tail),
        st.text("0123456789.,-en\n\"'", max_size=40).map(
            lambda tail: ("sequence,direction\nabc," + tail).encode()
        ),
    )
)
@settings(max_examples=300)
def test_any_bytes_are_labels_or_a_clear_error(scratch, data):
    try:
        labels = read_directions(scratch(data))
    except McnError:
        return
    assert labels.dtype == int
