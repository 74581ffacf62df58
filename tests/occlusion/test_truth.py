"""One truth of occlusion: hand-made boxes with known answers, and every recording alike."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.errors import ArgumentError, McnError
from mcnlab.occlusion.composites import compose, compose_all
from mcnlab.occlusion.pairs import RULES, find_pairs
from mcnlab.occlusion.truth import cover_of, find_occlusions, middle_of

sides = st.floats(0.5, 200)
boxes = st.tuples(st.floats(-200, 200), st.floats(-200, 200), sides, sides)


def share(first, second):
    """Cover of two boxes, and the middle of their intersection, one number at a time."""
    (x, y, w, h), (u, v, a, b) = first, second
    left, right, top, bottom = max(x, u), min(x + w, u + a), max(y, v), min(y + h, v + b)
    cover = max(right - left, 0) * max(bottom - top, 0) / min(w * h, a * b)
    # Half a pixel from the edges: pixels count from the centre of the first.
    return cover, (left + right - 1) / 2, (top + bottom - 1) / 2


def film(*boxes):
    """Boxes of one walker, one a frame, as x, y, w, h of shape (1, frames)."""
    return [np.array(values, float)[None] for values in zip(*boxes, strict=True)]


STILL = [(10, 0, 10, 40)] * 4


@pytest.mark.parametrize(
    ("other", "seen", "answer"),
    [
        # A shared strip of 10 × 40 less the gap; 3 columns are 0.3 of the box, and not more.
        ([(30, 0, 10, 40), (18, 0, 10, 40), (17, 0, 10, 40), (16, 0, 10, 40)], "1111", (3, 17.5)),
        ([(30, 0, 10, 40), (16, 0, 10, 40), (12, 0, 10, 40), (30, 0, 10, 40)], "1111", (1, 17.5)),
        ([(30, 0, 10, 40), (16, 0, 10, 40), (12, 0, 10, 40), (30, 0, 10, 40)], "1011", (2, 15.5)),
        ([(12, 0, 10, 40), (30, 0, 10, 40), (30, 0, 10, 40), (30, 0, 10, 40)], "1111", None),
        ([(30, 0, 10, 40), (16, 0, 10, 40), (30, 0, 10, 40), (30, 0, 10, 40)], "1011", None),
    ],
    ids=["bound", "first frame", "unseen", "only now", "never seen"],
)
def test_known_answers(other, seen, answer):
    both = np.array([[flag == "1" for flag in seen]])
    truth = find_occlusions(film(*STILL), film(*other), both, cover=0.3)
    assert truth.occludes.tolist() == [answer is not None]
    if answer is not None:
        # 40 rows from 0 on have their middle between rows 19 and 20.
        assert (truth.frame[0], truth.x[0], truth.y[0]) == (*answer, 19.5)


def test_pixels_count_from_the_centre_of_the_first():
    # One box of one pixel lies on that pixel; columns 2, 3 and 4 have their middle at 3.
    assert middle_of((7, 8, 1, 1), (7, 8, 1, 1)) == (7, 8)
    assert middle_of((0, 0, 5, 9), (2, 0, 9, 9)) == (3, 4)


def test_a_pair_that_is_not_followed_does_not_occlude():
    box = film((0, 0, 9, 9))
    truth = find_occlusions(box, box, np.array([[True]]), cover=0.3)
    assert (truth.now[0], truth.occludes[0], truth.frame[0]) == (1, False, 0)


def test_pairs_and_composites_tell_one_truth(casia):
    """Every composite that is a pair, too: the same verdict, frame and place."""
    table = compose_all(casia, focal_length=450).table
    table = table[table["shift"] == 0].sample(150, random_state=3)
    compared = 0
    for row in table.itertuples():
        both = compose(casia, row.first, row.second)
        if both.subjects[row.first] == both.subjects[row.second]:
            continue
        try:
            pairs = find_pairs(both)
        except McnError:
            continue  # not followed for long enough
        at = np.flatnonzero(pairs.frame == row.frame)
        if len(at) == 0:
            continue
        at, compared = int(at[0]), compared + 1
        soon = row.seconds <= RULES.horizon
        assert pairs.occludes[at] == soon
        if soon:
            held = pairs.seconds[at], pairs.x[at], pairs.y[at]
            assert held == pytest.approx((row.seconds, row.x, row.y), abs=1e-12)
    assert compared > 20


@given(first=boxes, second=boxes)
def test_a_cover_is_a_share_and_has_no_first_and_second(first, second):
    cover = cover_of(first, second)
    assert 0 <= cover <= 1
    assert cover == cover_of(second, first)
    # Sums of up to 400 are rounded by 6e-14, against sides of at least 0.5.
    assert cover == pytest.approx(share(first, second)[0], abs=1e-12)


@given(first=boxes, second=boxes, factor=st.sampled_from([0.5, 4.0]))
def test_a_cover_does_not_depend_on_the_scale(first, second, factor):
    larger = [tuple(factor * value for value in box) for box in (first, second)]
    assert cover_of(*larger) == cover_of(first, second)


def test_boxes_that_touch_do_not_cover():
    box = (10, 20, 5, 8)
    for other in ((15, 20, 5, 8), (10, 28, 5, 8), (5, 20, 5, 8), (15, 28, 1, 1), (99, 20, 5, 8)):
        assert cover_of(box, other) == 0


def test_a_box_inside_another_is_wholly_covered():
    assert cover_of((0, 0, 10, 10), (2, 3, 4, 5)) == 1
    assert cover_of((0, 0, 10, 10), (0, 0, 10, 10)) == 1
    assert cover_of((0, 0, 10, 10), (5, 0, 10, 20)) == 0.5


def test_covers_broadcast():
    x = np.arange(3.0)
    cover = cover_of((x[:, None], 0, 2, 2), (x, [0], 2, 2))
    np.testing.assert_array_equal(cover, [[1, 0.5, 0], [0.5, 1, 0.5], [0, 0.5, 1]])
    assert cover_of(([0], [0], [1], [2]), ([0], [1], [1], [2])).tolist() == [0.5]


@pytest.mark.parametrize("box", [(0, 0, 0, 1), (0, 0, 1, -1), (np.nan, 0, 1, 1), (0, 0, np.inf, 1)])
def test_what_is_no_box_has_no_cover(box):
    with pytest.raises(ArgumentError, match=r"^first\."):
        cover_of(box, (0, 0, 1, 1))
    with pytest.raises(ArgumentError, match=r"^second\."):
        cover_of((0, 0, 1, 1), box)
