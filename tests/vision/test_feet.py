"""Feet in silhouette images whose people are known."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab.cameras.homography import project
from mcnlab.errors import ArgumentError
from mcnlab.vision.feet import (
    PersonSizes,
    find_feet,
    person_sizes,
    trunk_widths,
)

SLOW = settings(max_examples=30)


WIDTH, HEIGHT, RATE, PIXEL = 320, 160, 10.0, 0.04


TALL, WIDE = 40, 14


SIZES = PersonSizes(np.full((HEIGHT, WIDTH), float(TALL)), np.full((HEIGHT, WIDTH), 12.0))


def draw(frame, x, y, level=200):
    """A person in grey: trunk and two legs, the feet's middle at (x, y)."""
    left, top = round(x - WIDE / 2), round(y) - TALL + 1
    frame[top : top + 26, left : left + WIDE] = level
    for leg in (left + 1, left + 8):
        frame[top : top + TALL, leg : leg + 5] = level
    return (slice(top, top + TALL), slice(left, left + WIDE))


def blank():
    return np.zeros((HEIGHT, WIDTH), np.uint8)


@given(st.integers(20, 300), st.integers(50, 155))
def test_one_person_has_one_foot_point(x, y):
    mask = blank()
    draw(mask, x, y)
    feet = find_feet(mask, SIZES)
    assert len(feet) == 1
    # Columns are those of the trunk's box, tried at every second pixel: 1 and rounding; the
    # feet's row is measured, and its lower edge is one below.
    assert feet[0, 0] == pytest.approx(x, abs=2)
    assert feet[0, 1] == pytest.approx(y + 1, abs=1)


@given(st.integers(20, 250), st.integers(50, 155), st.integers(13, 40))
def test_two_side_by_side_are_two(x, y, apart):
    mask = blank()
    draw(mask, x, y)
    draw(mask, x + apart, y)
    feet = find_feet(mask, SIZES)
    assert len(feet) == 2
    # Where silhouettes melt into one the cut between them may be off by a leg's width.
    assert np.sort(feet[:, 0]) == pytest.approx([x, x + apart], abs=5)


def test_a_person_in_pieces_is_one():
    mask = blank()
    draw(mask, 100, 100)
    mask[70:74] = mask[84:88] = 0  # cut below the head and at the hips
    assert len(find_feet(mask, SIZES)) == 1


def test_one_behind_another_is_seen_by_what_sticks_out():
    mask = blank()
    draw(mask, 100, 100)
    draw(mask, 102, 120)
    assert len(find_feet(mask, SIZES)) == 2


def test_specks_are_nobody():
    mask = blank()
    mask[::9, ::7] = 255
    assert find_feet(mask, SIZES).shape == (0, 4)
    assert find_feet(blank(), SIZES).shape == (0, 4)


@given(st.integers(70, 240), st.integers(50, 125), st.integers(16, 40))
def test_a_mirrored_mask_has_mirrored_feet(x, y, apart):
    mask = blank()
    draw(mask, x, y)
    draw(mask, x + apart, y + apart // 2)
    straight, mirrored = find_feet(mask, SIZES), find_feet(mask[:, ::-1].copy(), SIZES)
    # The places tried are not their own mirror image: one may be preferred to another two
    # pixels off, and where two people melt, what is left for the second differs by as much.
    assert len(straight) == len(mirrored)
    assert np.sort(WIDTH - 1 - mirrored[:, 0]) == pytest.approx(np.sort(straight[:, 0]), abs=5)


@pytest.mark.parametrize(
    ("mask", "words"),
    [
        (np.zeros((5, 5)), "shape"),
        (np.full((HEIGHT, WIDTH), np.nan), "finite"),
        (np.full((HEIGHT, WIDTH), "a"), "finite numbers"),
    ],
    ids=["shape", "nan", "text"],
)
def test_a_mask_that_is_none_is_refused(mask, words):
    with pytest.raises(ArgumentError, match=words):
        find_feet(mask, SIZES)
    with pytest.raises(ArgumentError, match="sizes"):
        find_feet(blank(), PersonSizes(SIZES.tall * np.nan, SIZES.wide))


def test_places_too_far_away_and_all_above_them_are_left_out():
    # A camera 5 m up that looks at the horizon in row 40: row r is at 5·100/(r − 40) m.
    sky = 40.0
    to_ground = partial(project, [[5, 0, -5 * 160], [0, 0, 500], [0, 1, -sky]])
    widths = trunk_widths((160, 320), to_ground, coarsest=0.25)
    # From row to row 500/(r − 40)² m or so: 0.25 m at row 85 (one row in between).
    seen = np.flatnonzero(widths[:, 160] > 0)
    assert seen.min() in (84, 85) and seen.max() == 159
    assert not widths[: int(sky)].any()  # beyond the horizon the homography mirrors the ground
    # The trunk is 0.49 m wide, a pixel is 5/(r − 40) m.
    assert widths[100, 160] == pytest.approx(0.49 * 60 / 5)
    sizes = person_sizes(widths, lambda points: 0.3 * (points[:, 1] - sky))
    assert sizes.tall[100, 160] == pytest.approx(18)
    assert sizes.tall[84:86].max() > 0 and sizes.wide[sizes.tall == 0].max() == 0


@pytest.mark.parametrize("lean", [-0.5, 0.3])
def test_a_camera_that_leans_sees_all_the_ground_below_its_horizon(lean):
    # As above, but the horizon falls or rises by `lean` rows a column about the middle.
    columns, rows = np.meshgrid(np.arange(320.0), np.arange(160.0))
    below = rows - 40 - lean * (columns - 160)
    matrix = np.array([[5, 0, -5 * 160], [0, 0, 500], [-lean, 1, 160 * lean - 40]])
    widths = trunk_widths((160, 320), partial(project, matrix), coarsest=0.25)
    # What is looked at is below the horizon, and what is well below it is looked at: there a
    # pixel is at most 5/b + 800·|lean|/b² or 500·(1 + |lean|)/b² m wide or high, b rows below.
    assert below[widths > 0].min() > 0
    assert (widths[below > 80] > 0).all()
