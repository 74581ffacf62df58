"""Middlebury's files: what is written is read, and damage is named."""

import struct

import cv2
import numpy as np
import pytest

from mcnlab.datasets import middlebury
from mcnlab.errors import DatasetError
from mcnlab.vision import flow

HEIGHT, WIDTH = 12, 16


def flo(truth):
    height, width = truth.shape[:2]
    return struct.pack("<fii", 202021.25, width, height) + truth.astype("<f4").tobytes()


def a_truth():
    return np.random.default_rng(0).normal(size=(HEIGHT, WIDTH, 2)).astype(np.float32)


@pytest.fixture
def folder(tmp_path):
    """Sequences "Chair" and "Apple", and a folder that is none."""
    rng = np.random.default_rng(0)
    for name in ("Chair", "Apple"):
        inner = tmp_path / name
        inner.mkdir()
        for file in (middlebury.FIRST, middlebury.SECOND):
            image = rng.integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)
            (inner / file).write_bytes(cv2.imencode(".png", image)[1].tobytes())
        (inner / middlebury.TRUTH).write_bytes(flo(a_truth()))
    (tmp_path / "notes").mkdir()
    (tmp_path / "readme.txt").write_text("about")
    return tmp_path


def test_sequences_are_found_by_name(folder):
    assert [found.name for found in middlebury.find_sequences(folder)] == ["Apple", "Chair"]
    assert [found.name for found in middlebury.find_sequences(str(folder))] == ["Apple", "Chair"]


def test_a_sequence_is_two_grey_frames_and_the_truth(folder):
    first, second, truth = middlebury.find_sequences(folder)[0].read()
    assert first.shape == second.shape == (HEIGHT, WIDTH)
    assert first.dtype == second.dtype == np.uint8
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(truth, a_truth())


def test_what_is_written_is_read_and_unknown_pixels_are_nan(tmp_path):
    truth = a_truth()
    truth[2, 3] = 1.666e9
    truth[4, 5, 1] = -2e9
    truth[6, 7] = np.nan
    (tmp_path / "true.flo").write_bytes(flo(truth))
    found = middlebury.read_flo(tmp_path / "true.flo")
    assert found.dtype == np.float32
    unknown = np.zeros((HEIGHT, WIDTH), bool)
    unknown[[2, 4, 6], [3, 5, 7]] = True
    np.testing.assert_array_equal(np.isnan(found), np.dstack([unknown, unknown]))
    np.testing.assert_array_equal(found[~unknown], truth[~unknown])
    assert flow.end_point_error(np.nan_to_num(found), found) == 0
    found[0, 0] = 0  # it is a copy that may be written into


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "not a flow file"),
        (b"HEIP" + flo(a_truth())[4:], "not a flow file"),
        (flo(a_truth())[:10], "truncated: it ends after 10 bytes"),
        (flo(a_truth())[:-1], "truncated: 16×12 pixels take 1548 bytes, it has 1547"),
        (flo(a_truth()) + b"\0", "too long"),
        (b"PIEH" + struct.pack("<ii", 0, 5), "0×5 pixels"),
        (b"PIEH" + struct.pack("<ii", -4, -5), "-4×-5 pixels"),
        (b"PIEH" + struct.pack("<ii", 2**31 - 1, 2**31 - 1), "pixels"),
    ],
)
def test_a_damaged_truth_is_refused(tmp_path, data, words):
    (tmp_path / "true.flo").write_bytes(data)
    with pytest.raises(DatasetError, match=words):
        middlebury.read_flo(tmp_path / "true.flo")


def test_a_missing_truth_is_refused(tmp_path):
    with pytest.raises(DatasetError, match=r"true\.flo is missing"):
        middlebury.read_flo(tmp_path / "true.flo")


def test_a_missing_or_empty_folder_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="is missing"):
        middlebury.find_sequences(tmp_path / "none")
    with pytest.raises(DatasetError, match="holds no sequences"):
        middlebury.find_sequences(tmp_path)


def test_half_a_sequence_is_refused(folder):
    (folder / "Chair" / middlebury.SECOND).unlink()
    with pytest.raises(DatasetError, match=r"Chair lacks frame11\.png"):
        middlebury.find_sequences(folder)


def test_damaged_frames_are_refused(folder):
    sequence = middlebury.find_sequences(folder)[0]
    path = sequence.folder / middlebury.FIRST
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DatasetError, match=r"frame10\.png is truncated"):
        sequence.read()
    path.write_bytes(b"GIF89a")
    with pytest.raises(DatasetError, match="not a PNG"):
        sequence.read()
    path.unlink()
    with pytest.raises(DatasetError, match=r"frame10\.png is missing"):
        sequence.read()


def test_files_of_different_size_are_refused(folder):
    sequence = middlebury.find_sequences(folder)[0]
    (sequence.folder / middlebury.TRUTH).write_bytes(flo(a_truth()[1:]))
    with pytest.raises(DatasetError, match=r"flow10\.flo 16×11"):
        sequence.read()


def test_the_real_sequences_read(recordings):
    for sequence in middlebury.find_sequences(recordings / middlebury.NAME):
        first, second, truth = sequence.read()
        assert first.shape == second.shape == truth.shape[:2]
        known = np.isfinite(truth).all(axis=-1)
        assert known.mean() > 0.5
        assert np.abs(truth[known]).max() < 100  # pixels; the largest published are some 35
