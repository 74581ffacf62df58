"""Groups of directions; separators against every possible placement."""

from itertools import combinations_with_replacement

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.base import BaseEstimator, ClassifierMixin

from mcnlab import tables
from mcnlab.compass import DIRECTIONS
from mcnlab.datasets.mirror import mirror_boxes, mirror_direction
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, McnError
from mcnlab.tables import uncut
from mcnlab.walking.direction import (
    GROUP_NAMES,
    GROUPS,
    LinearSeparators,
    group_of,
    leave_one_subject_out,
    measure_phase_space,
    phase_space_classifier,
)

# Distinct phases a quarter apart at least: their middles are exact.
phases = st.integers(-20, 20).map(lambda value: value / 4)


def test_a_direction_and_its_mirror_image_make_a_group():
    assert group_of(DIRECTIONS).tolist() == [1, 2, 3, 4, 5, 4, 3, 2]
    for direction in DIRECTIONS:
        assert group_of(direction) == group_of(mirror_direction(direction))
        assert str(direction) in GROUP_NAMES[int(group_of(direction))]
    assert set(GROUPS) == set(GROUP_NAMES)


@pytest.mark.parametrize("directions", [0, 9, [1, 2, 10], -1, 2.5, np.nan, "away"])
def test_only_one_to_eight_have_a_group(directions):
    with pytest.raises(ArgumentError, match="1 to 8"):
        group_of(directions)


def test_whole_numbers_have_a_group_whatever_their_type():
    assert group_of([1.0, 8.0]).tolist() == [1, 2]


def brute_force(phase, groups, order):
    """The most videos that level lines can set right: every placement is tried."""
    values = np.unique(phase)
    middles = [-np.inf, *(values[1:] + values[:-1]) / 2, np.inf]
    best = 0
    for cuts in combinations_with_replacement(middles, len(order) - 1):
        said = np.array(order)[np.searchsorted(cuts, phase)]
        best = max(best, np.count_nonzero(said == groups))
    return best


@given(st.lists(st.tuples(phases, st.sampled_from(GROUPS[:4])), min_size=1, max_size=12))
def test_no_placement_of_the_separators_is_better(videos):
    phase, groups = map(np.array, zip(*videos, strict=True))
    separators = LinearSeparators().fit(phase, groups)
    means = [phase[groups == group].mean() for group in separators.order_]
    assert (np.diff(means) >= 0).all()
    assert sorted(separators.order_) == sorted(set(groups))
    right = np.count_nonzero(separators.predict(phase) == groups)
    assert right == brute_force(phase, groups, list(separators.order_))


@given(st.lists(st.tuples(phases, st.sampled_from(GROUPS)), min_size=2, max_size=40), phases)
def test_predictions_are_where_the_cuts_say(videos, value):
    phase, groups = map(np.array, zip(*videos, strict=True))
    separators = LinearSeparators().fit(phase[:, None], groups)
    assert len(separators.cuts_) == len(set(groups)) - 1
    assert (separators.cuts_[1:] >= separators.cuts_[:-1]).all()
    (said,) = separators.predict([value])
    assert said == separators.order_[np.count_nonzero(separators.cuts_ < value)]
    # A separator lies midway between training phases, so on none of them.
    assert not np.isin(separators.cuts_, phase).any()


def test_of_equally_good_places_the_widest_gap_is_taken():
    # Right of 0, or right of 2: one video is lost either way, and the second gap is wider.
    assert LinearSeparators().fit([0, 1, 2, 9, 10], list("ababb")).cuts_.tolist() == [5.5]
    assert LinearSeparators().fit([0, 8, 9, 10, 11], list("ababb")).cuts_.tolist() == [4]


def test_separators_are_also_given_as_coefficients():
    separators = LinearSeparators().fit([0, 1, 4, 5], [1, 1, 2, 2])
    assert separators.coef_.tolist() == [[1.0]]
    assert separators.coef_[:, 0] * 2.5 + separators.intercept_ == 0


@pytest.mark.parametrize(
    ("X", "y"), [([], []), ([1, 2], [1]), ([1, np.nan], [1, 2]), (np.ones((3, 2)), [1, 2, 3])]
)
def test_phases_that_do_not_fit_the_groups_are_refused(X, y):
    with pytest.raises(ArgumentError, match="X"):
        LinearSeparators().fit(X, y)


class Spy(ClassifierMixin, BaseEstimator):
    """Says the subject of the row it is asked about, and fails when it has seen it before."""

    def fit(self, X, y):
        self.seen_ = set(X[:, 0])
        self.classes_ = np.unique(y)
        assert len(X) == len(y) > 0
        return self

    def predict(self, X):
        assert len(set(X[:, 0])) == 1
        assert not self.seen_ & set(X[:, 0])
        return X[:, 1]


@given(st.lists(st.integers(0, 5), min_size=2, max_size=30).filter(lambda who: len(set(who)) > 1))
def test_whoever_is_left_out_is_not_learned_from(subjects):
    answers = np.arange(len(subjects))
    said = leave_one_subject_out(Spy(), np.c_[subjects, answers], answers, subjects)
    assert said.tolist() == answers.tolist()


def test_leaving_one_out_of_one_is_refused():
    with pytest.raises(ArgumentError, match="one subject only"):
        leave_one_subject_out(LinearSeparators(), [1, 2], [1, 2], ["abc", "abc"])


@pytest.mark.parametrize(("y", "subjects"), [([1, 2], "abc"), ([1, 2, 3], "ab")])
def test_walks_groups_and_subjects_must_be_as_many(y, subjects):
    with pytest.raises(ArgumentError):
        leave_one_subject_out(LinearSeparators(), [1, 2, 3], y, list(subjects))


def test_a_box_at_the_edge_is_not_trusted_unless_most_are(make_boxes):
    boxes = pd.concat(
        [
            make_boxes(4, sequence="right", x=[100.0, 200, 300, 312], w=40.0),
            make_boxes(4, sequence="left", x=[0.0, 1, 2, 3]),
            make_boxes(4, sequence="top", y=[0.0, 0, 0, 5]),
            make_boxes(4, sequence="foot", y=60.0, h=[100.0, 179, 180, 200]),
        ],
        ignore_index=True,
    )
    trusted = uncut(tables.stack_sequences(boxes), 352, 240)
    assert trusted.tolist() == [
        [True, True, True, False],
        [False, True, True, True],
        [True, True, True, True],  # three of four would go: all stay
        [True, True, True, True],  # and so here: two are fewer than PRESENT of four
    ]


def grown(make_boxes, rate, sideways, n=30):
    """A walk whose box grows by `rate` a second and moves `sideways` px a second."""
    time = np.arange(n) / 25
    h = 100 * np.exp(rate * time)
    x = 150 + sideways * time
    return make_boxes(n, x=x, y=100 - h / 2, w=0.4 * h, h=h, cx=x + 20, cy=100.0)


def test_the_phase_space_holds_the_rates_of_a_made_up_walk(make_boxes):
    boxes = grown(make_boxes, rate=0.2, sideways=30.0)
    space = measure_phase_space(Recording("made-up", boxes, 25.0, 352, 240))
    assert space.index.tolist() == ["walk"]
    assert space.loc["walk", "height_growth"] == pytest.approx(0.2)
    assert space.loc["walk", "width_growth"] == pytest.approx(0.2)
    assert space.loc["walk", "sideways"] == pytest.approx(30 / boxes["h"].mean())


def test_a_mirrored_walk_differs_in_its_sideways_motion_only(make_boxes):
    boxes = grown(make_boxes, rate=-0.1, sideways=40.0)
    mirrored = mirror_boxes(boxes, frame_width=352)
    here, there = (
        measure_phase_space(Recording("made-up", rows, 25.0, 352, 240))
        for rows in (boxes, mirrored)
    )
    growth = ["height_growth", "width_growth"]
    assert here[growth].equals(there[growth])
    assert there["sideways"].tolist() == pytest.approx((-here["sideways"]).tolist())


def test_a_walk_of_one_frame_has_no_phase_space(make_boxes):
    with pytest.raises(McnError, match="two different"):
        measure_phase_space(Recording("made-up", make_boxes(1), 25.0, 352, 240))


def test_the_phase_space_classifier_separates_what_lines_can_separate():
    rng = np.random.default_rng(0)
    corners = np.array([[0, 0], [9, 0], [0, 9]])
    y = np.repeat([1, 2, 3], 20)
    X = corners[y - 1] + rng.uniform(-1, 1, (60, 2))
    subjects = np.tile(np.arange(5), 12)
    said = leave_one_subject_out(phase_space_classifier(), X, y, subjects)
    assert (said == y).all()
