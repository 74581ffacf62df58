"""Videos of which every frame is known, and videos that are not whole."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mcnlab.datasets.video import open_video
from mcnlab.errors import ArgumentError, DatasetError

N, HEIGHT, WIDTH = 12, 48, 64


@pytest.fixture(scope="module")
def stripes():
    """Frames in which the frame number is a grey level: 20 k."""
    return np.stack([np.full((HEIGHT, WIDTH), 20 * k, np.uint8) for k in range(N)])


@pytest.fixture
def folder(tmp_path, stripes):
    # Written without leading zeros: frame 10 sorts before frame 2 by letters.
    for number, frame in enumerate(stripes):
        cv2.imwrite(str(tmp_path / f"frame{number}.png"), frame)
    (tmp_path / "notes.txt").write_text("not a frame")
    return tmp_path


@pytest.fixture
def film(tmp_path, stripes):
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (WIDTH, HEIGHT))
    for frame in stripes:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


def levels(frames):
    return [int(np.rint(frame.mean() / 20)) for frame in frames]


def test_a_file_gives_its_frames_in_order_as_often_as_asked(film):
    video = open_video(film)
    assert (video.name, video.frame_rate) == ("film", 10)
    assert (video.width, video.height, len(video)) == (WIDTH, HEIGHT, N)
    assert levels(video) == levels(video) == list(range(N))


def test_a_part_of_a_file_is_the_same_frames(film):
    video = open_video(film)
    assert levels(video.frames(3, 7)) == [3, 4, 5, 6]
    whole = list(video)
    assert all(np.array_equal(a, b) for a, b in zip(whole[3:7], video.frames(3, 7), strict=True))


def test_a_folder_is_read_in_natural_order(folder):
    video = open_video(folder, frame_rate=7)
    assert video.n_frames == N
    assert levels(video) == list(range(N))
    assert levels(video.frames(9, 12)) == [9, 10, 11]


def test_frames_in_memory_are_a_video(stripes):
    video = open_video(stripes, frame_rate=7, name="stripes")
    assert (video.name, video.width, video.height) == ("stripes", WIDTH, HEIGHT)
    assert np.array_equal(np.stack(list(video)), stripes)


def test_frames_are_grey_or_in_colour(film, folder, stripes):
    videos = [open_video(source, frame_rate=7) for source in (film, folder, stripes)]
    for video in videos:
        grey, colour = next(iter(video)), next(video.frames(colour=True))
        assert (grey.shape, grey.dtype) == ((HEIGHT, WIDTH), np.uint8)
        assert (colour.shape, colour.dtype) == ((HEIGHT, WIDTH, 3), np.uint8)


def test_ones_own_frame_rate_overrides_the_containers(film):
    assert open_video(film, frame_rate=7.0).frame_rate == 7


def test_a_folder_does_not_know_its_frame_rate(folder):
    with pytest.raises(ArgumentError, match="frame_rate is not known"):
        open_video(folder)


@pytest.mark.parametrize("rate", [0, -1, np.nan, np.inf, "7"])
def test_an_impossible_frame_rate_is_refused(stripes, rate):
    with pytest.raises(ArgumentError, match="frame_rate"):
        open_video(stripes, frame_rate=rate)


def test_a_file_that_is_missing_or_no_video_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="missing"):
        open_video(tmp_path / "none.mp4")
    (tmp_path / "text.mp4").write_text("no video")
    with pytest.raises(DatasetError, match="cannot be opened"):
        open_video(tmp_path / "text.mp4")
    with pytest.raises(ArgumentError, match="source is a int"):
        open_video(5)


def test_a_file_that_ends_early_is_refused_where_it_ends(film):
    video = replace(open_video(film), n_frames=N + 3)
    with pytest.raises(DatasetError, match="ends early: frame 12 of the 15"):
        list(video)
    # What lies before the end can be had.
    assert levels(video.frames(0, N)) == list(range(N))


def test_a_file_cut_in_two_is_refused(film):
    data = film.read_bytes()
    film.write_bytes(data[: len(data) // 2])
    with pytest.raises(DatasetError, match=r"film\.avi"):
        list(open_video(film))


def test_an_empty_folder_and_a_damaged_image_are_refused(tmp_path, folder):
    (tmp_path / "empty").mkdir()
    with pytest.raises(DatasetError, match="holds no images"):
        open_video(tmp_path / "empty", frame_rate=7)
    (folder / "frame5.png").write_bytes(b"no image")
    with pytest.raises(DatasetError, match=r"frame5\.png is not an image"):
        list(open_video(folder, frame_rate=7))


def test_a_frame_of_another_size_is_named(folder):
    cv2.imwrite(str(folder / "frame4.png"), np.zeros((HEIGHT, WIDTH + 1), np.uint8))
    with pytest.raises(DatasetError, match="frame 4 is 65×48 pixels, the first one 64×48"):
        list(open_video(folder, frame_rate=7))


def test_one_frame_is_no_video(stripes):
    with pytest.raises(DatasetError, match="one frame"):
        open_video(stripes[:1], frame_rate=7)


@pytest.mark.parametrize(
    "frames",
    [
        np.zeros((3, 4, 5)),
        np.zeros((4, 5), np.uint8),
        np.zeros((0, 4, 5), np.uint8),
        np.zeros((3, 4, 5, 2), np.uint8),
    ],
    ids=["floats", "one image", "empty", "two colours"],
)
def test_an_array_that_is_not_of_frames_is_refused(frames):
    with pytest.raises(ArgumentError, match="source"):
        open_video(frames, frame_rate=7)


@pytest.mark.parametrize("part", [(5, 5), (6, 5), (0, N + 1), (-1, 5), (0.5, 3)])
def test_a_part_outside_the_video_is_refused(stripes, part):
    with pytest.raises(ArgumentError, match="start"):
        open_video(stripes, frame_rate=7).frames(*part)
