"""Directions and headings as printed, and turns between them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.compass import DIRECTIONS, NAMES, direction_of, heading_of, turn_between
from mcnlab.errors import ArgumentError


def test_directions_run_clockwise_from_away():
    assert heading_of(DIRECTIONS).tolist() == [0, 45, 90, 135, 180, 225, 270, 315]
    assert [NAMES[d] for d in (1, 3, 5, 7)] == ["away", "right", "toward", "left"]


@pytest.mark.parametrize("direction", [0, 9, 1.5, np.nan])
def test_only_one_to_eight_have_a_heading(direction):
    with pytest.raises(ArgumentError, match="1 to 8"):
        heading_of(direction)


@given(st.floats(-1000, 1000))
def test_a_heading_belongs_to_the_nearest_direction(heading):
    direction = direction_of(heading)
    assert direction in DIRECTIONS
    # Eight directions are 45° apart, so the nearest is at most 22.5° away.
    assert abs(turn_between(heading, heading_of(direction))) <= 22.5 + 1e-9
    assert direction_of(heading + 360) == direction or abs(heading / 45 % 1 - 0.5) < 1e-9


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_heading_of_a_direction_gives_it_back(direction):
    assert direction_of(heading_of(direction)) == direction
    assert direction_of(heading_of(direction) + 22) == direction
    assert direction_of(heading_of(direction) - 22) == direction


@pytest.mark.parametrize("heading", [np.nan, np.inf, [0, -np.inf]])
def test_a_heading_that_is_not_finite_has_no_direction(heading):
    with pytest.raises(ArgumentError, match="heading"):
        direction_of(heading)


@given(st.floats(-720, 720), st.floats(-720, 720))
def test_a_turn_leads_from_one_heading_to_the_other(heading, reference):
    turn = turn_between(heading, reference)
    # 1e-9: headings of up to 720 are rounded to 2⁻⁴³.
    assert -180 <= turn <= 180
    assert np.cos(np.radians(reference + turn - heading)) == pytest.approx(1, abs=1e-12)
    back = turn_between(reference, heading)
    assert turn + back == pytest.approx(0, abs=1e-9) or abs(turn) == pytest.approx(180)


def test_a_turn_right_is_positive():
    assert turn_between(10, 350) == 20
    assert turn_between(350, 10) == -20
    assert turn_between(180, 0) == -180
