"""The judges, and the two promises that synthetic walkers can check: interval and noise."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.noise import SegmentationNoise
from mcnlab.synthetic.walkers import CASIA_VIEW, make_walks
from mcnlab.walking import heading
from mcnlab.walking.evaluation import (
    HARD_NOISE,
    accuracy_under_noise,
    calibration,
    judge_headings,
    judge_pets,
    record_walks,
    sample_sequences,
    time_videos,
)


@pytest.fixture(scope="module")
def walked():
    """Synthetic people, sixteen walks each in all headings: (recording, true headings)."""
    boxes, headings = [], {}
    for seed in range(500, 540):
        walks = make_walks(subjects=1, seed=seed, repeats=2, spread=22.5)
        table = record_walks(walks, n_jobs=2).boxes
        boxes.append(
            table.assign(sequence=table["sequence"] + f"@{seed}", subject=f"subject {seed}")
        )
        headings |= {f"{walk.name}@{seed}": walk.heading for walk in walks}
    view = CASIA_VIEW
    recording = Recording(
        "synthetic", pd.concat(boxes, ignore_index=True), 25, view.frame_width, view.frame_height
    )
    return recording, headings


def test_the_interval_of_a_walk_holds_the_heading_95_times_in_100(walked):
    recording, true = walked
    headings = heading.measure_headings(recording, focal_length=CASIA_VIEW.focal_length)
    truth = headings["sequence"].map(true).to_numpy()
    held = calibration(headings, truth, levels=[0.95])[0]
    assert held.n == 640
    assert 0.93 <= held.value <= 0.97


@pytest.mark.parametrize("window", [25, 12])
def test_the_interval_of_a_window_is_not_too_narrow(walked, window):
    recording, true = walked
    headings = heading.measure_headings(
        recording, focal_length=CASIA_VIEW.focal_length, window=window
    )
    truth = headings["sequence"].map(true).to_numpy()
    held = calibration(headings, truth, levels=[0.95])[0]
    # Windows of one walk share its gait, and the shorter ones err on the careful side.
    assert 0.93 <= held.value <= 0.99


def test_the_closed_form_stands_hard_noise():
    found = accuracy_under_noise([0, 1], subjects=4, seed=2, n_jobs=2)
    assert found["perspective"][0].value == 1
    assert found["perspective"][1].value >= 0.95
    hard = HARD_NOISE
    assert (hard.specks, hard.cut_limbs, hard.missing) == (20, 1, 0.05)


def test_noise_that_hides_a_walker_counts_as_wrong():
    blind = SegmentationNoise(occluder=(0, 0, 352, 240))
    with pytest.raises(ArgumentError, match="turn it down"):
        accuracy_under_noise([1], subjects=1, noise=blind, n_jobs=1)


def test_judging_headings_by_hand():
    boxes = make_walks(subjects=2, directions=(1, 3), seed=0)
    recording = record_walks(boxes)
    headings = pd.DataFrame(
        {
            "sequence": recording.sequences,
            "heading": [350.0, 80.0, 30.0, 90.0],
            "direction": [1, 3, 2, 3],
        }
    )
    right, error, signed = judge_headings(recording, headings)
    np.testing.assert_allclose(signed, [-10, -10, 30, 0])
    assert right.value == 0.75
    assert error.value == 12.5
    assert error.n == 2


def test_judging_pets_by_hand():
    headings = pd.DataFrame(
        {
            "sequence": ["1", "1", "2", "2"],
            "sight": [5.0, 90.0, 180.0, 0.0],
            "true_sight": [0.0, 140.0, 170.0, 180.0],
            "true_speed": [1.0, 1.0, 1.0, 0.1],
            "error": [5.0, -50.0, 10.0, -180.0],
        }
    )
    judged = judge_pets(headings)
    assert judged["direction8"].value == pytest.approx(2 / 3)
    assert judged["within45"].value == pytest.approx(2 / 3)
    assert judged["mae_deg"].value == pytest.approx(65 / 3)
    with pytest.raises(ArgumentError, match="least_speed"):
        judge_pets(headings, least_speed=9)


def test_timing_reads_real_files_and_leaves_none_behind():
    with sample_sequences(most=8) as sequences:
        folder = sequences[0].paths[0].parents[3]
        assert len(time_videos(sequences[:2], focal_length=450)) == 2
        assert folder.is_dir()
    assert not folder.exists()


def test_a_recording_of_nothing_is_refused():
    with pytest.raises(ArgumentError, match="walks is empty"):
        record_walks([])
