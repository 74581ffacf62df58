"""Flows against known motions, the paper's arithmetic and Middlebury's truth."""

from functools import lru_cache

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab.datasets import middlebury
from mcnlab.errors import ArgumentError
from mcnlab.plotting import vision
from mcnlab.vision import flow

HEIGHT, WIDTH = 96, 128


@lru_cache
def texture(seed=0, height=HEIGHT, width=WIDTH):
    """A picture, 0 … 255, with structure from 2 to 16 pixels; it wraps around."""
    rng = np.random.default_rng(seed)
    picture = np.zeros((height, width))
    for size in (2, 4, 8, 16):
        noise = rng.standard_normal((height, width))
        noise = cv2.GaussianBlur(np.tile(noise, (3, 3)), (0, 0), size)
        noise = noise[height : 2 * height, width : 2 * width]
        picture += size * noise / noise.std()
    return 255 * (picture - picture.min()) / np.ptp(picture)


def shifted(picture, dx, dy):
    """The picture moved by any (dx, dy), wrapped around: exact, by Fourier's shift theorem."""
    wave_y = np.fft.fftfreq(picture.shape[0])[:, None]
    wave_x = np.fft.fftfreq(picture.shape[1])
    turn = np.exp(-2j * np.pi * (wave_x * dx + wave_y * dy))
    return np.fft.ifft2(np.fft.fft2(picture) * turn).real


def moved_by(u, v):
    """Two frames of which the first shows, at each pixel, the second at (x + u, y + v)."""
    second = texture()
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    to = (x + u).astype(np.float32), (y + v).astype(np.float32)
    first = cv2.remap(
        second.astype(np.float32), *to, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT
    )
    return first, second, np.stack(np.broadcast_arrays(u, v), -1)


def constant(dx, dy, shape=(HEIGHT, WIDTH)):
    return np.broadcast_to(np.array([dx, dy], float), (*shape, 2))


@pytest.fixture(params=sorted(flow.METHODS))
def method(request):
    return flow.METHODS[request.param]


# Whole-number shifts of a wrapping picture are exact in whole grey levels, too.  The pixels that
# leave the frame are the border's; 0.3 pixels is what the least accurate, Farnebäck, needs.
def test_every_method_finds_a_pixel_right_and_half_a_pixel_up(method):
    first = texture(1)
    second = np.clip(np.rint(shifted(first, 1.0, -0.5)), 0, 255).astype(np.uint8)
    first = np.rint(first).astype(np.uint8)
    found = method(first, second)
    assert found.shape == (HEIGHT, WIDTH, 2)
    assert found.dtype == np.float32
    assert flow.end_point_error(found, constant(1, -0.5)) < 0.3


def test_frames_without_change_do_not_move(method):
    picture = np.rint(texture()).astype(np.uint8)
    found = method(picture, picture)
    # Farnebäck's does move a little: its window reaches over the edge.
    assert np.abs(found).max() <= (0.2 if method is flow.farneback else 0)


def test_constant_frames_do_not_move(method):
    found = method(np.full((40, 60), 7, np.uint8), np.full((40, 60), 9, np.uint8))
    assert found.shape == (40, 60, 2)
    assert np.abs(found).max() < 1e-5  # pixels: a slope of 0 is so to float32's rounding


def test_one_iteration_is_the_paper_s_on_a_ramp():
    # I = 3x + 2y, moved by (0.5, 0.25): I_t = −(1.5 + 0.5) = −2.  From rest the paper's update
    # is u = −I_x I_t / (α² + I_x² + I_y²) = 6 / (16 + 13) and v = 4 / 29.  Two pixels from the
    # edge the slopes see it not.
    y, x = np.mgrid[:20, :30].astype(float)
    first = 3 * x + 2 * y
    second = 3 * (x - 0.5) + 2 * (y - 0.25)
    found = flow.horn_schunck_plain(first, second, alpha=4, iterations=1, presmooth=0)
    np.testing.assert_allclose(found[2:-2, 2:-2], constant(6 / 29, 4 / 29, (16, 26)), rtol=1e-5)


def test_two_iterations_are_the_paper_s_arithmetic():
    first, second = texture(2)[:40, :50], shifted(texture(2), 0.3, 0.2)[:40, :50]
    found = flow.horn_schunck_plain(first, second, alpha=5, iterations=2, presmooth=0)
    mean = (first + second) / 2
    slope = np.array([1, -8, 0, 8, -1]) / 12
    inner = slice(2, -2)
    x = np.stack([np.convolve(row, slope[::-1], "valid") for row in mean])[inner]
    y = np.stack([np.convolve(row, slope[::-1], "valid") for row in mean.T])[inner].T
    t = (second - first)[inner, inner]
    u = v = np.zeros_like(t)
    for _ in range(2):
        u, v = (
            sum(
                weight * np.roll(part, (down, right), (0, 1)) / 12
                for down, right, weight in [
                    *((0, s, 2) for s in (-1, 1)),
                    *((s, 0, 2) for s in (-1, 1)),
                    *((s, r, 1) for s in (-1, 1) for r in (-1, 1)),
                ]
            )
            for part in (u, v)
        )
        common = (x * u + y * v + t) / (25 + x**2 + y**2)
        u, v = u - x * common, v - y * common
    # float32 carries seven digits of grey levels to 255, slopes of which are some 10.
    np.testing.assert_allclose(found[3:-3, 3:-3, 0], u[1:-1, 1:-1], atol=2e-5)
    np.testing.assert_allclose(found[3:-3, 3:-3, 1], v[1:-1, 1:-1], atol=2e-5)


def test_relaxation_arrives_at_the_same_solution_sooner():
    first, second = texture(3), shifted(texture(3), 0.4, 0.3)
    one_level = {"levels": 1, "warps": 1, "median": 0, "tolerance": 0}
    solution = flow.horn_schunck_plain(first, second, iterations=5000)
    plain = flow.horn_schunck_plain(first, second, iterations=60)
    ahead = flow.horn_schunck(first, second, iterations=60, relaxation=1.6, **one_level)
    still = flow.horn_schunck(first, second, iterations=2000, relaxation=1.6, **one_level)
    assert np.abs(still - solution).max() < 1e-4
    assert flow.end_point_error(ahead, solution) < 0.5 * flow.end_point_error(plain, solution)


def test_tolerance_stops_at_the_solution_and_not_before():
    first, second = texture(3), shifted(texture(3), 0.4, 0.3)
    full = flow.horn_schunck_plain(first, second, iterations=5000)
    early = flow.horn_schunck_plain(first, second, iterations=5000, tolerance=1e-4)
    assert 0 < np.abs(early - full).max() < 0.05
    loose = flow.horn_schunck_plain(first, second, iterations=5000, tolerance=1e9)
    np.testing.assert_array_equal(
        loose, flow.horn_schunck_plain(first, second, iterations=5)
    )  # the first look is after five iterations


# The pixels that leave the frame are filled in from their neighbours: of a band as wide as the
# shift, at most 17 of 240 rows, some tenth of the pixels may be wrong by half a pixel.  Within,
# interpolating linearly at half pixels errs by w²/32 of a slope for structure of w radians a
# pixel; here w is 1/2 at most: 0.008 pixels.
@pytest.mark.parametrize("shift", [(0.4, 0.3), (-0.25, 0.1), (3, 2), (-5, 4), (9.5, -7.25)])
def test_any_shift_is_found_from_coarse_to_fine(shift):
    first = texture(4, 240, 320)
    found = flow.horn_schunck(first, shifted(first, *shift))
    error = np.linalg.norm(found - constant(*shift, first.shape), axis=-1)
    assert np.median(error) < 0.01
    assert error.mean() < 0.05


def test_plain_iteration_is_for_motions_under_a_pixel():
    first = texture(5, 240, 320)
    errors = [
        flow.end_point_error(
            flow.horn_schunck_plain(first, shifted(first, d, 0)), constant(d, 0, first.shape)
        )
        for d in (0.5, 6)
    ]
    assert errors[0] < 0.1
    assert errors[1] > 1


def test_rotation_and_zoom_are_found():
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    x, y = x - WIDTH / 2, y - HEIGHT / 2
    for u, v in ((-0.03 * y, 0.03 * x), (0.03 * x, 0.03 * y)):
        first, second, truth = moved_by(u, v)
        found = flow.horn_schunck(first, second)
        inner = np.s_[8:-8, 8:-8]  # zooming brings in at most 2 unseen pixels at each side
        assert flow.end_point_error(found[inner], truth[inner]) < 0.05


@pytest.mark.parametrize("name", ["horn-schunck", "horn-schunck-plain"])
@pytest.mark.parametrize("size", [(96, 128), (75, 101)])
def test_one_level_mirrors_with_the_frames(name, size):
    first = texture(6)[: size[0], : size[1]]
    second = shifted(texture(6), 0.8, -0.6)[: size[0], : size[1]]
    # An even side is halved to every other pixel from the left, so the pyramid's mirror is not
    # exact; one level's is, but for rounding.  OpenCV warps to the nearest 64th of a pixel here,
    # and rounding may tip a pixel to the next one.
    options = {"levels": 1} if name == "horn-schunck" else {}
    found = flow.METHODS[name](first, second, **options)
    mirror = flow.METHODS[name](first[:, ::-1], second[:, ::-1], **options)[:, ::-1]
    bound = 1 / 64 if name == "horn-schunck" else 1e-4
    np.testing.assert_allclose(mirror * [-1, 1], found, rtol=0, atol=bound)


def test_the_pyramid_mirrors_with_the_frames():
    first, second = texture(6), shifted(texture(6), 4, -3)
    found = flow.horn_schunck(first, second)
    mirror = flow.horn_schunck(first[:, ::-1], second[:, ::-1])[:, ::-1] * [-1, 1]
    assert flow.end_point_error(mirror, found) < 0.05


def test_swapped_axes_swap_the_flow():
    first, second = texture(6), shifted(texture(6), 0.7, -0.4)
    found = flow.horn_schunck_plain(first, second)
    turned = flow.horn_schunck_plain(first.T, second.T)
    np.testing.assert_allclose(turned.transpose(1, 0, 2)[..., ::-1], found, atol=1e-4)


def test_swapped_frames_reverse_the_flow():
    first, second = texture(7), shifted(texture(7), 0.6, 0.4)
    there, back = flow.horn_schunck_plain(first, second), flow.horn_schunck_plain(second, first)
    # Without warping both slopes are the frames' mean, the same; only I_t changes its sign.
    np.testing.assert_allclose(back, -there, atol=1e-4)
    first, second = texture(7), shifted(texture(7), 4, -3)
    there, back = flow.horn_schunck(first, second), flow.horn_schunck(second, first)
    assert flow.end_point_error(back, -there) < 0.05


@settings(max_examples=15)
@given(st.floats(0.01, 300), st.floats(-500, 500), st.floats(1, 50))
def test_only_alpha_over_contrast_matters(contrast, brightness, alpha):
    first, second = texture(8), shifted(texture(8), 0.6, 0.4)
    found = flow.horn_schunck(first, second, alpha=alpha, tolerance=0)
    # Brightness is added after scaling, in which float32 keeps seven digits.
    brightness *= contrast
    scaled = flow.horn_schunck(
        contrast * first + brightness,
        contrast * second + brightness,
        alpha=contrast * alpha,
        tolerance=0,
    )
    assert np.abs(scaled - found).max() < 0.02


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.uint16, np.int64, np.float16, np.float64])
def test_every_type_of_number_gives_the_same_flow(method, kind):
    first, second = np.rint(texture()), np.rint(np.clip(shifted(texture(), 1, 1), 0, 255))
    expected = method(first.astype(np.float32), second.astype(np.float32))
    np.testing.assert_array_equal(method(first.astype(kind), second.astype(kind)), expected)


def test_views_and_other_orders_of_memory_give_the_same_flow(method):
    first, second = (
        np.rint(np.clip(f, 0, 255)).astype(np.uint8) for f in (texture(), shifted(texture(), 1, 0))
    )
    expected = method(first[::2, ::-1].copy(), second[::2, ::-1].copy())
    np.testing.assert_array_equal(method(first[::2, ::-1], second[::2, ::-1]), expected)
    np.testing.assert_array_equal(
        method(*(np.asfortranarray(f[::2, ::-1]) for f in (first, second))), expected
    )


def test_frames_are_left_as_they_were(method):
    first, second = (np.rint(np.clip(shifted(texture(), d, 0), 0, 255)) for d in (0, 2))
    first.flags.writeable = second.flags.writeable = False
    method(first, second)


def test_a_flow_is_the_same_every_time(method):
    first, second = (np.rint(np.clip(shifted(texture(), d, 0), 0, 255)) for d in (0, 2))
    np.testing.assert_array_equal(method(first, second), method(first, second))


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (3, 3), (7, 100), (16, 16), (17, 33)])
def test_tiny_frames_have_a_finite_flow(shape):
    rng = np.random.default_rng(0)
    for name in ("horn-schunck", "horn-schunck-plain", "farneback"):
        found = flow.METHODS[name](*rng.integers(0, 256, (2, *shape), dtype=np.uint8))
        assert found.shape == (*shape, 2)
        assert np.isfinite(found).all(), name


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        (np.zeros((20, 30)), np.zeros((30, 20)), "second has the shape .*, first"),
        (np.zeros((20, 30)), None, "second has the shape"),
        (np.zeros((2, 20, 30)), np.zeros((20, 30)), "one grey image"),
        (np.zeros((20, 30, 3)), np.zeros((20, 30, 3)), "turns a colour image grey"),
        (np.zeros(20), np.zeros(20), "one grey image"),
        (np.zeros((0, 20)), np.zeros((0, 20)), "one grey image"),
        (np.zeros((20, 30), bool), np.zeros((20, 30), bool), "of bool"),
        (np.zeros((20, 30), complex), np.zeros((20, 30)), "complex"),
        (np.zeros((20, 30), object), np.zeros((20, 30)), "of object"),
        ("frame.png", np.zeros((20, 30)), "first holds what is no number"),
        ([[1, 2], [3]], np.zeros((20, 30)), "first holds what is no number"),
        (np.full((20, 30), np.nan), np.zeros((20, 30)), "first is nan in row 0, 0"),
        (np.zeros((20, 30)), np.full((20, 30), np.inf), "second is inf in row 0, 0"),
        (np.zeros((1, 16384)), np.zeros((1, 16384)), "at most 16383"),
    ],
)
def test_frames_that_are_no_pair_are_refused(method, first, second, words):
    with pytest.raises(ArgumentError, match=words):
        method(first, second)


def test_one_frame_is_no_pair(method):
    with pytest.raises(TypeError, match="second"):
        method(np.zeros((20, 30)))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"alpha": 0}, "alpha is 0"),
        ({"alpha": -1}, "alpha is -1"),
        ({"alpha": np.nan}, "alpha is nan"),
        ({"alpha": 1e9}, r"alpha is 1000000000\.0; .*at most 1e\+06"),
        ({"alpha": 1e-20}, "larger alpha"),
        ({"alpha": 1e-320}, "larger alpha"),
        ({"iterations": -1}, "iterations is -1"),
        ({"iterations": 0}, "iterations is 0"),
        ({"iterations": 1.5}, "iterations is 1.5"),
        ({"iterations": 10**9}, "iterations is .*at most 100000"),
        ({"levels": 0}, "levels is 0"),
        ({"levels": 9}, "levels is 9; .*at most 5"),
        ({"levels": "all"}, "'auto'"),
        ({"levels": None}, "levels is None"),
        ({"warps": 0}, "warps is 0"),
        ({"warps": 10**6}, "warps is .*at most 1000"),
        ({"tolerance": -1}, "tolerance is -1"),
        ({"presmooth": -1}, "presmooth is -1"),
        ({"presmooth": 1e9}, "presmooth is"),
        ({"median": -1}, "median is -1"),
        ({"median": 10**6}, "median is .*at most 1000"),
        ({"relaxation": 2}, "below 2"),
        ({"relaxation": 0}, "relaxation is 0"),
    ],
)
def test_impossible_options_are_refused(options, words):
    with pytest.raises(ArgumentError, match=words):
        flow.horn_schunck(texture(), texture(), **options)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"levels": 0}, "levels is 0"),
        ({"levels": 100}, "levels is 100; .*at most 10"),
        ({"window": 1}, "window is 1"),
        ({"window": 10**5}, "window is 100000; .*at most 1000"),
        ({"window": 15.0}, "window is 15.0"),
        ({"iterations": 0}, "iterations is 0"),
        ({"iterations": 10**9}, "iterations is .*at most 100000"),
        ({"neighbourhood": 6}, "neighbourhood is 6"),
        ({"spread": 0}, "spread is 0"),
        ({"spread": 1e9}, "spread is .*at most 10"),
        ({"spread": np.nan}, "spread is nan"),
    ],
)
def test_impossible_options_of_farneback_are_refused(options, words):
    with pytest.raises(ArgumentError, match=words):
        flow.farneback(texture(), texture(), **options)


def test_impossible_options_of_dis_are_refused():
    with pytest.raises(ArgumentError, match="'medium'"):
        flow.dis(texture(), texture(), preset="best")
    with pytest.raises(ArgumentError, match="at least 12"):
        flow.dis(np.zeros((11, 40)), np.zeros((11, 40)))
    with pytest.raises(ArgumentError, match="too long and narrow"):
        flow.dis(np.zeros((12, 3000)), np.zeros((12, 3000)))


@pytest.mark.parametrize("name", ["dis", "farneback"])
@pytest.mark.parametrize("picture", [texture() / 255, 2 * texture(), texture() - 100])
def test_grey_levels_off_the_8_bit_scale_are_refused(name, picture):
    with pytest.raises(ArgumentError, match="scale them to 0 … 255"):
        flow.METHODS[name](picture, picture)


def test_farneback_takes_its_options_to_their_ends():
    first, second = texture(), np.clip(shifted(texture(), 1, 0), 0, 255)
    widest = {"levels": 10, "window": 1000, "iterations": 1, "neighbourhood": 7, "spread": 10}
    assert np.isfinite(flow.farneback(first, second, **widest)).all()


def test_end_point_error_counts_known_pixels_only():
    truth = np.zeros((2, 2, 2))
    truth[0, 0] = np.nan
    truth[0, 1] = 1.7e9
    found = np.full((2, 2, 2), np.nan)
    found[1, 0] = 3, 4
    found[1, 1] = 0, 1
    assert flow.end_point_error(found, truth) == 3.0


@pytest.mark.parametrize(
    ("found", "truth", "words"),
    [
        (np.zeros((2, 3, 2)), np.zeros((3, 2, 2)), "flow has the shape .*, truth"),
        (np.zeros((2, 3)), np.zeros((2, 3, 2)), "flow has the shape"),
        (np.zeros((2, 3, 2)), "truth", "truth holds what is no number"),
        (np.zeros((2, 3, 2)), np.full((2, 3, 2), np.nan), "unknown in every pixel"),
        (np.zeros((2, 3, 2)), np.full((2, 3, 2), 1e10), "unknown in every pixel"),
        (np.full((2, 3, 2), np.nan), np.zeros((2, 3, 2)), "not finite"),
    ],
)
def test_errors_of_what_cannot_be_compared_are_refused(found, truth, words):
    with pytest.raises(ArgumentError, match=words):
        flow.end_point_error(found, truth)


def test_what_is_fast_enough_moves():
    arrows = np.array([[[3, 4], [3, 3.9], [0, 0], [-5, 0]]], np.float32)
    mask = flow.moving_mask(arrows, speed=5)
    assert mask.dtype == np.uint8
    assert mask.tolist() == [[255, 0, 0, 255]]


@pytest.mark.parametrize(
    ("arrows", "speed", "words"),
    [
        (np.zeros((2, 3, 2)), 0, "speed is 0"),
        (np.zeros((2, 3, 2)), np.nan, "speed is nan"),
        (np.zeros((2, 3)), 1, "flow has the shape"),
        (np.full((2, 3, 2), np.nan), 1, "flow is nan in row 0"),
    ],
)
def test_motion_of_what_is_no_flow_is_refused(arrows, speed, words):
    with pytest.raises(ArgumentError, match=words):
        flow.moving_mask(arrows, speed=speed)


def test_colours_are_middlebury_s():
    arrows = [[[0, 0], [2, 0], [1, 0], [4, 0], [np.nan, 0], [2e9, 0]]]
    assert vision.colour_flow(arrows, largest=2).tolist() == [
        [[255, 255, 255], [255, 0, 0], [255, 128, 128], [191, 0, 0], [0, 0, 0], [0, 0, 0]]
    ]
    # Down is a quarter turn, 13.75 of the wheel's 55 steps: between yellow at 15 and red at 0.
    assert vision.colour_flow([[[0, 1]]]).tolist() == [[[255, round(255 * 13.75 / 15), 0]]]


@given(st.floats(0.01, 100), st.floats(0, 360))
def test_colour_tells_direction_and_share_of_the_largest_speed(largest, degrees):
    arrow = largest * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    full, half = vision.colour_flow([[arrow, arrow / 2]], largest=1.000001 * largest)[0].astype(int)
    assert full.max() == 255  # hues lie on the rim of the colour cube
    assert full.min() == 0
    assert np.abs(half - (255 + full) / 2).max() <= 1


def test_rest_is_white_and_the_largest_speed_is_found():
    assert (vision.colour_flow(np.zeros((2, 3, 2))) == 255).all()
    arrows = np.random.default_rng(0).normal(size=(5, 6, 2))
    largest = np.linalg.norm(arrows, axis=-1).max()
    np.testing.assert_array_equal(
        vision.colour_flow(arrows), vision.colour_flow(arrows, largest=largest)
    )


def test_the_legend_paints_each_direction_where_it_points():
    legend = vision.colour_legend(101)
    assert legend.shape == (101, 101, 3)
    assert legend[50, 50].tolist() == [255, 255, 255]
    assert legend[50, 100].tolist() == [255, 0, 0]  # right
    assert legend[0, 0].tolist() == [255, 255, 255]  # beyond the circle
    np.testing.assert_array_equal(legend[100, 50], vision.colour_flow([[[0, 1]]])[0, 0])  # down
    np.testing.assert_array_equal(legend[50, 0], vision.colour_flow([[[-1, 0]]])[0, 0])  # left


@pytest.mark.parametrize(
    ("arrows", "largest", "words"),
    [
        (np.zeros((2, 3)), 1, "flow has the shape"),
        (np.full((2, 3, 2), np.nan), 1, "no pixel that is known"),
        (np.zeros((2, 3, 2)), 0, "largest is 0"),
    ],
)
def test_colours_of_what_is_no_flow_are_refused(arrows, largest, words):
    with pytest.raises(ArgumentError, match=words):
        vision.colour_flow(arrows, largest=largest)


def test_a_legend_needs_room():
    with pytest.raises(ArgumentError, match="size is 1"):
        vision.colour_legend(1)


def test_no_sequence_of_middlebury_is_farneback_s(recordings):
    samples = {"levels": 3, "window": 15, "iterations": 3, "neighbourhood": 5, "spread": 1.2}
    for sequence in middlebury.find_sequences(recordings / middlebury.NAME):
        first, second, truth = sequence.read()
        here = flow.end_point_error(flow.horn_schunck(first, second), truth)
        for options in ({}, samples):
            there = flow.end_point_error(flow.farneback(first, second, **options), truth)
            assert here <= there, sequence.name
