"""Which cameras move: the benchmark's word, and the estimate for any other."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.datasets.motchallenge import find_sequences, read_sequence
from mcnlab.datasets.recording import Recording
from mcnlab.errors import DatasetError
from mcnlab.vision.camera_motion import MOVING, SHARED, STATIC, known_motion, moves, shared_motion


def test_the_benchmark_says_which_of_its_cameras_move():
    assert not STATIC & MOVING
    for name in ("mot17-02-frcnn", "MOT17-04-DPM", "mot16-09", "MOT20-03", "PETS09-S2L1"):
        assert known_motion(name) is False
    for name in ("mot17-05-sdp", "MOT16-13", "MOT17-11", "ETH-Bahnhof", "KITTI-13"):
        assert known_motion(name) is True
    for name in ("mot17-15", "mot20-09", "mot17-02frcnn", "02", "walkers", ""):
        assert known_motion(name) is None


def make_crowd(*, shake=0.0, people=12, seconds=10, rate=20, seed=0):
    """People who walk each with random accelerations, in a camera that shakes at random."""
    random = np.random.default_rng(seed)
    frames = seconds * rate
    own = random.normal(size=(2, people, frames))
    together = shake * random.normal(size=(2, 1, frames))
    cx, cy = own + together + random.uniform(100, 900, size=(2, people, 1))
    names = np.repeat([str(k) for k in range(people)], frames)
    table = {"sequence": names, "subject": names, "frame": np.tile(1 + np.arange(frames), people)}
    table |= {"x": cx.ravel() - 10, "y": cy.ravel() - 30, "w": 20.0, "h": 60.0}
    table |= {"cx": cx.ravel(), "cy": cy.ravel()}
    return Recording("crowd", pd.DataFrame(table), rate, 1000, 1000)


@pytest.mark.parametrize("shake", [0.0, 0.5, 1.0, 3.0])
def test_the_shared_share_is_that_of_the_variances(shake):
    # Own accelerations have variance v, the camera's shake² v, so the share is
    # shake² / (1 + shake²).  It is a ratio of sums over 190 frames, of which second
    # differences leave about a third independent: with 12 people its standard error is
    # about share · √(2/63) + 1/√(63 · 66), here under 0.15; the largest of four lies
    # above, by one to two standard errors.
    share = shared_motion(make_crowd(shake=shake))
    assert abs(share - shake**2 / (1 + shake**2)) < 3 * (
        shake**2 / (1 + shake**2) ** 2 * np.sqrt(2 / 63) + 1 / np.sqrt(63 * 66)
    )


def test_a_camera_that_moves_everything_alike_shares_all():
    still = make_crowd()
    boxes = still.boxes
    wave = 20 * np.sin(boxes["frame"].to_numpy() / 3)
    starts = boxes.groupby("sequence")["cx"].transform("first").to_numpy()
    moved = boxes.assign(cx=starts + wave, x=starts + wave - 10, cy=50.0, y=20.0)
    # Rounding of numbers up to 1000 leaves 1e-13 of accelerations of about 20.
    assert shared_motion(still.with_boxes(moved)) == pytest.approx(1, abs=1e-9)
    assert moves(still.with_boxes(moved))


def test_people_who_stand_or_walk_evenly_share_nothing():
    still = make_crowd()
    step = still.boxes["frame"].to_numpy(float)
    even = still.boxes.assign(cx=4 * step, x=4 * step - 10, cy=50.0, y=20.0)
    assert shared_motion(still.with_boxes(even)) == 0
    assert not moves(still.with_boxes(even))


def test_shifting_the_clock_or_mirroring_changes_no_share():
    crowd = make_crowd(shake=0.7)
    share = shared_motion(crowd)
    boxes = crowd.boxes
    later = crowd.with_boxes(boxes.assign(frame=boxes["frame"] + 5000))
    assert shared_motion(later) == share
    mirrored = boxes.assign(cx=1000 - boxes["cx"], x=1000 - boxes["x"] - boxes["w"])
    # Products of a few hundred accelerations, each rounded to 1e-13.
    assert shared_motion(crowd.with_boxes(mirrored)) == pytest.approx(share, abs=1e-9)


def test_the_benchmarks_word_counts_more_than_the_estimate():
    shaken = make_crowd(shake=5.0)
    assert moves(shaken)
    assert not moves(shaken.with_boxes(shaken.boxes, name="mot20-01"))
    assert moves(make_crowd().with_boxes(make_crowd().boxes, name="mot16-05"))


@pytest.mark.parametrize("change", [{"people": 1}, {"seconds": 1, "rate": 2}])
def test_one_person_or_a_moment_tells_nothing_of_the_camera(change):
    crowd = make_crowd(**change)
    short = crowd.with_boxes(crowd.boxes[crowd.boxes["frame"] <= 8].reset_index(drop=True))
    with pytest.raises(DatasetError, match="never shows two people together"):
        moves(short)


def add_bob(recording, *, share=0.001, rate=2.0):
    """The same recording from a hand that bobs by a share of the frame's width."""
    boxes = recording.boxes
    time = boxes["frame"].to_numpy() / recording.frame_rate
    bob = share * recording.frame_width * np.sin(2 * np.pi * rate * time)
    return recording.with_boxes(boxes.assign(y=boxes["y"] + bob, cy=boxes["cy"] + bob))


@pytest.mark.parametrize(
    "name", ["mot17-02-frcnn", "mot17-04-frcnn", "pets09-s2l1", "tud-stadtmitte"]
)
def test_the_estimate_agrees_with_the_benchmark_on_real_sequences(recordings, name):
    found = find_sequences(recordings / "motchallenge")
    folder = next((path for path in found if path.name.lower() == name), None)
    if folder is None:
        pytest.skip(f"{name} is not here")
    recording = read_sequence(folder)
    assert known_motion(recording.name) is False
    # Well clear of the bound on either side.
    assert shared_motion(recording) < SHARED / 3
    assert shared_motion(add_bob(recording)) > 2 * SHARED
