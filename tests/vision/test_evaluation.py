"""Judges of flow and of traces, by hand."""

import numpy as np
import pandas as pd
import pytest

from mcnlab import statistics
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.shifts import make_motion
from mcnlab.vision import flow
from mcnlab.vision.evaluation import flow_errors, judge_traces


def test_flow_errors_are_those_of_each_method_on_each_sequence():
    motions = {name: make_motion(name, shape=(40, 60))[1:] for name in ("shifting", "parting")}
    first, second, truth = motions["parting"]
    known = truth.copy()
    known[:5] = np.nan  # as Middlebury marks what is not known
    errors = flow_errors({**motions, "part known": (first, second, known)})
    assert list(errors.index) == ["shifting", "parting", "part known"]
    assert list(errors.columns) == list(flow.METHODS)
    for method, find in flow.METHODS.items():
        away = np.linalg.norm(find(first, second) - truth, axis=2)
        assert errors.loc["parting", method] == pytest.approx(away.mean())
        assert errors.loc["part known", method] == pytest.approx(away[5:].mean())


@pytest.fixture
def scored():
    """Points and feet of three people, by hand: (points, feet)."""
    points = pd.DataFrame(
        {
            "trace": ["t1", "t1", "t2", "t2", "t2"],
            "frame": [5, 6, 4, 6, 7],
            "matched": [True, True, False, True, False],
            "error": [0.1, 0.3, 1.0, 0.5, 1.0],
        }
    )
    feet = pd.DataFrame(
        {
            "trace": ["a", "a", "b", "b", "c"],
            "frame": [5, 6, 6, 7, 3],
            "found": [True, True, True, False, False],
            "error": [0.1, 0.3, 0.5, 1.0, 1.0],
        }
    )
    return points, feet


def test_judging_traces_by_hand(scored):
    judged = judge_traces(*scored)
    assert {name: estimate.value for name, estimate in judged.items()} == {
        "recall": pytest.approx(3 / 5),
        "precision": pytest.approx(3 / 5),
        "median_error_m": 0.3,
    }
    assert [estimate.n for estimate in judged.values()] == [3, 2, 2]  # walkers, traces, found
    points, feet = scored
    assert judged["recall"] == statistics.mean_by_subject(feet["found"], feet["trace"])
    assert judged["precision"] == statistics.mean_by_subject(points["matched"], points["trace"])
    assert judged["median_error_m"] == statistics.median_by_subject(
        [0.1, 0.3, 0.5], ["a", "a", "b"]
    )


def test_frames_before_the_first_are_not_judged(scored):
    judged = judge_traces(*scored, first=6)
    assert judged["recall"].value == pytest.approx(2 / 3)
    assert judged["precision"].value == pytest.approx(2 / 3)
    assert judged["median_error_m"].value == pytest.approx(0.4)


@pytest.mark.parametrize("shuffle", [False, True])
def test_truth_kept_as_numbers_or_in_another_order_is_judged_alike(scored, shuffle):
    points, feet = scored
    judged = judge_traces(points, feet)
    if shuffle:
        points, feet = points.iloc[::-1], feet.sample(frac=1, random_state=0)
    other = judge_traces(points.astype({"matched": int}), feet.astype({"found": int}), first=0)
    for name, estimate in judged.items():
        assert other[name] == pytest.approx(estimate)


def test_nothing_left_to_judge_is_refused(scored):
    with pytest.raises(ArgumentError, match="first is 8: there is nothing to judge"):
        judge_traces(*scored, first=8)
    points, feet = scored
    with pytest.raises(ArgumentError):
        judge_traces(points, feet.assign(found=False))
