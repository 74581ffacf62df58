"""True motion on the ground, of people whose places were made up."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.errors import DatasetError
from mcnlab.tables import FRAME, SEQUENCE, WORLD_X, WORLD_Y
from mcnlab.walking.truth import true_headings, true_motion


@pytest.fixture
def world():
    """Eleven frames a tenth of a second apart: 2 m/s east from (0, 10), 1 m/s north from (0, 5)."""
    frames, time = np.arange(1, 12), np.arange(11) / 10
    east = {SEQUENCE: "east", FRAME: frames, WORLD_X: 2 * time, WORLD_Y: 10.0}
    north = {SEQUENCE: "north", FRAME: frames, WORLD_X: 0.0, WORLD_Y: 5 + time}
    return pd.concat([pd.DataFrame(east), pd.DataFrame(north)], ignore_index=True)


def windows_of(*rows):
    return pd.DataFrame(rows, columns=[SEQUENCE, FRAME])


def test_places_and_velocities_are_those_of_the_walk(world):
    windows = windows_of(("east", 1), ("north", 1), ("east", 11), ("nobody", 1))
    place, velocity = true_motion(world, windows, window=11, frame_rate=10)
    np.testing.assert_allclose(place[:2], [[1, 10], [0, 5.5]])
    np.testing.assert_allclose(velocity[:2], [[2, 0], [0, 1]], atol=1e-9)
    # One position is no motion, and none is no place either.
    assert np.isnan(place[2:]).all()
    assert np.isnan(velocity[2:]).all()


def test_headings_are_clockwise_from_straight_away(world):
    windows = windows_of(("east", 1), ("north", 1))
    truth = true_headings(world, windows, place=(1, 0), window=11, frame_rate=10)
    assert truth["true_speed"].tolist() == pytest.approx([2, 1])
    # (1, 10) seen from (1, 0) lies due north; (0, 5.5) lies to its left.
    left = np.degrees(np.arctan(1 / 5.5))
    assert truth["true_sight"].tolist() == pytest.approx([90, left])


def test_a_window_without_positions_has_no_heading(world):
    with pytest.raises(DatasetError, match="no two positions of 'nobody'"):
        true_headings(world, windows_of(("nobody", 1)), place=(0, 0), window=5, frame_rate=10)


def test_a_person_twice_in_a_frame_is_refused(world):
    twice = pd.concat([world, world.iloc[:1]], ignore_index=True)
    with pytest.raises(DatasetError, match="twice"):
        true_motion(twice, windows_of(("east", 1)), window=5, frame_rate=10)
