"""Made motions: the second frame, looked up where the truth says, is the first."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from mcnlab.errors import ArgumentError
from mcnlab.synthetic.shifts import MOTIONS, make_motion
from mcnlab.vision import flow


@pytest.mark.parametrize("name", MOTIONS)
def test_the_truth_takes_the_second_frame_back_to_the_first(name):
    motion = make_motion(name, seed=1)
    height, width = motion.first.shape
    assert motion.second.shape == (height, width) == (240, 320)
    assert motion.first.dtype == motion.second.dtype == np.uint8
    assert motion.truth.shape == (height, width, 2)
    assert motion.truth.dtype == np.float32
    y, x = np.mgrid[:height, :width]
    x, y = x + motion.truth[..., 0], y + motion.truth[..., 1]
    held = (x >= 4) & (x <= width - 5) & (y >= 4) & (y <= height - 5)
    back = map_coordinates(motion.second.astype(float), [y, x], order=3)
    # Both frames are rounded, by 1/2 at most; cubic splines pass that of the second on up to
    # 1.55-fold along each axis.
    bound = 0.5 + 0.5 * 1.55**2
    assert np.abs(back - motion.first)[held].max() < bound
    # The other way round it does not fit, so the sign is told.
    wrong = map_coordinates(motion.first.astype(float), [y, x], order=3, mode="nearest")
    assert np.abs(wrong - motion.second)[held].max() > 2 * bound
    assert held.mean() > 0.9


def test_a_shift_by_whole_pixels_is_exact():
    motion = make_motion("shifting")
    np.testing.assert_array_equal(motion.first[:-2, :-3], motion.second[2:, 3:])
    assert (motion.truth == [3.0, 2.0]).all()


def test_each_motion_is_what_it_says():
    height, width = 41, 61
    middle = (20, 30)
    truth = {name: make_motion(name, shape=(height, width)).truth for name in MOTIONS}
    np.testing.assert_allclose(truth["creeping"], np.full((height, width, 2), (0.4, 0.3)))
    assert (truth["turning"][middle] == 0).all()
    # Ten pixels to the right of the middle: 1 % farther, 2° on; y is down, so clockwise.
    arrow = 10.1 * np.exp(1j * np.radians(2)) - 10
    np.testing.assert_allclose(truth["turning"][20, 40], (arrow.real, arrow.imag), rtol=1e-5)
    assert (truth["parting"][..., 1] == 0).all()
    np.testing.assert_allclose(truth["parting"][0], -truth["parting"][-1])
    np.testing.assert_allclose(truth["parting"][-1, :, 0], 2 * np.tanh(20 / 12), rtol=1e-6)


@pytest.mark.parametrize("name", MOTIONS)
def test_the_pyramid_finds_every_motion(name):
    motion = make_motion(name)
    # A tenth of a pixel: flows that use the whole frame do better, one that is wrong does not.
    assert flow.end_point_error(flow.horn_schunck(motion.first, motion.second), motion.truth) < 0.1
    assert np.abs(motion.truth).max() > 0.3


def test_the_texture_is_the_seeds_and_fills_the_grey_levels():
    motion, again = make_motion("creeping", seed=3), make_motion("creeping", seed=3)
    np.testing.assert_array_equal(motion.first, again.first)
    other = make_motion("creeping", seed=4)
    assert (other.first != motion.first).any()
    assert np.ptp(motion.second) > 128


@pytest.mark.parametrize("shape", [(16, 16), (16, 400), (101, 33)])
def test_odd_shapes_are_moved_too(shape):
    for name in MOTIONS:
        motion = make_motion(name, shape=shape)
        assert motion.first.shape == motion.second.shape == motion.truth.shape[:2] == shape


@pytest.mark.parametrize(
    ("name", "options", "word"),
    [
        ("falling", {}, "name is 'falling'"),
        ("shifting", {"shape": (15, 400)}, "at least 16 pixels"),
        ("shifting", {"shape": (0, 400)}, "at least 16 pixels"),
        ("shifting", {"shape": (20.5, 400)}, r"shape is 20\.5"),
        ("shifting", {"shape": 400}, "at least 16 pixels"),
        ("shifting", {"shape": (20, 20, 3)}, "at least 16 pixels"),
        ("shifting", {"seed": -1}, "seed is -1"),
        ("shifting", {"seed": 1.5}, r"seed is 1\.5"),
    ],
)
def test_motions_that_cannot_be_made_are_refused(name, options, word):
    with pytest.raises(ArgumentError, match=word):
        make_motion(name, **options)
