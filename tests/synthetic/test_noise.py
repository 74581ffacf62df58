"""Segmentation noise: each kind does what it says and no more."""

import math

import cv2
import numpy as np
import pytest

from mcnlab.errors import ArgumentError
from mcnlab.synthetic.body import Body
from mcnlab.synthetic.noise import CASIA_LIKE, LIMB_REGIONS, SegmentationNoise, add_noise
from mcnlab.synthetic.walkers import make_walk

EVERYTHING = SegmentationNoise(
    specks=3, holes=2, cut_limbs=2, missing=0.1, occluder=(150, 0, 20, 240)
)


@pytest.fixture(scope="module")
def walk():
    return make_walk(Body(), heading=90.0, distance=5.8)


@pytest.fixture(scope="module")
def masks(walk):
    return walk.masks


def components(mask):
    return cv2.connectedComponents(mask)[0] - 1


def test_no_noise_changes_nothing(masks):
    noisy = add_noise(masks, SegmentationNoise(), seed=1)
    np.testing.assert_array_equal(noisy, masks)
    assert not np.shares_memory(noisy, masks)


@pytest.mark.parametrize("noise", [EVERYTHING, CASIA_LIKE])
def test_the_input_is_untouched(masks, noise):
    before = masks.copy()
    noisy = add_noise(masks, noise, seed=1)
    np.testing.assert_array_equal(masks, before)
    assert noisy.dtype == np.uint8
    assert noisy.shape == masks.shape
    assert set(np.unique(noisy)) <= {0, 255}


def test_the_same_seed_gives_the_same_noise(masks):
    once, again, other = (add_noise(masks, EVERYTHING, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(once, again)
    assert (once != other).any()


def test_specks_come_in_the_number_and_size_asked_for():
    black = np.zeros((400, 240, 352), np.uint8)
    noisy = add_noise(black, SegmentationNoise(specks=2.0, speck_size=(2, 4)), seed=3)
    found = [cv2.connectedComponentsWithStats(mask)[2][1:] for mask in noisy]
    number = np.mean([len(stats) for stats in found])
    # 800 are expected, with a Poisson deviation of √800; very few overlap.
    assert abs(number - 2.0) < 4 * math.sqrt(800) / 400
    side = np.concatenate(found)[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]]
    assert side.min() == 2
    assert np.median(side.max(axis=1)) <= 4


def test_specks_only_add_and_holes_only_take(masks):
    specks = add_noise(masks, SegmentationNoise(specks=5), seed=1)
    holes = add_noise(masks, SegmentationNoise(holes=3), seed=1)
    assert (specks >= masks).all()
    assert (specks > masks).any()
    assert (holes <= masks).all()
    lost = (holes < masks).sum(axis=(1, 2))
    assert lost.mean() <= 3 * 6 * 6
    # A hole is centred on the body; only exp(−3) = 5 % of the frames get none.
    assert (lost > 0).mean() > 0.85


def test_holes_are_in_the_body_not_in_specks(walk, masks):
    specked = masks.copy()
    specked[:, :4, :4] = 255
    noisy = add_noise(specked, SegmentationNoise(holes=4), seed=1)
    inside = np.zeros_like(masks)
    for frame, box in zip(inside, walk.truth.itertuples(), strict=True):
        frame[box.y : box.y + box.h, box.x : box.x + box.w] = 255
    assert (noisy[:, :4, :4] == 255).all()
    assert (inside[noisy != specked] == 255).all()


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 1.0])
def test_missing_frames(masks, share):
    noisy = add_noise(masks, SegmentationNoise(missing=share), seed=4)
    black = ~noisy.any(axis=(1, 2))
    assert black.sum() == round(share * len(masks))
    np.testing.assert_array_equal(noisy[~black], masks[~black])


def test_nothing_shows_through_the_occluder(masks):
    noise = SegmentationNoise(specks=20, occluder=(150, 60, 40, 500))
    noisy = add_noise(masks, noise, seed=5)
    assert not noisy[:, 60:, 150:190].any()
    only = add_noise(masks, SegmentationNoise(occluder=(150, 60, 40, 500)), seed=5)
    outside = np.ones(masks.shape[1:], bool)
    outside[60:, 150:190] = False
    np.testing.assert_array_equal(only[:, outside], masks[:, outside])


@pytest.mark.parametrize("number", [1, 2, 4])
def test_cut_limbs_go_from_within_the_box_for_one_run(walk, masks, number):
    noise = SegmentationNoise(cut_limbs=number, cut_share=0.4)
    noisy = add_noise(masks, noise, seed=6)
    assert (noisy <= masks).all()
    changed = (noisy != masks).any(axis=(1, 2))
    assert changed.any()
    for mask, cut, box in zip(masks, noisy, walk.truth.itertuples(), strict=True):
        rows, cols = np.nonzero(mask != cut)
        if len(rows):
            # Rounding to whole pixels may reach half a pixel beyond a region.
            share = (rows.min() - box.y + 0.5) / box.h
            assert share >= 0.20
            assert box.x <= cols.min()
            assert cols.max() < box.x + box.w
    if number == 1:
        run = np.flatnonzero(changed)
        assert np.ptp(run) + 1 <= round(0.4 * len(masks))


def test_a_limb_may_go_at_any_time(masks):
    noise = SegmentationNoise(cut_limbs=1, cut_share=0.2)
    changed = [(add_noise(masks, noise, seed=s) != masks).any(axis=(1, 2)) for s in range(30)]
    first = np.array([run.argmax() for run in changed if run.any()])
    assert first.min() < 0.3 * len(masks)
    assert first.max() > 0.5 * len(masks)


def test_more_cut_limbs_include_the_fewer(masks):
    one, two = (add_noise(masks, SegmentationNoise(cut_limbs=n), seed=7) for n in (1, 2))
    assert (two <= one).all()


def test_cut_legs_shorten_the_body(masks):
    all_of_it = SegmentationNoise(cut_limbs=len(LIMB_REGIONS), cut_share=1.0)
    noisy = add_noise(masks, all_of_it, seed=8)
    heights = [
        cv2.boundingRect(mask)[3] / cv2.boundingRect(full)[3]
        for mask, full in zip(noisy, masks, strict=True)
    ]
    np.testing.assert_allclose(heights, 0.72, atol=0.02)


def test_kinds_do_not_disturb_each_other(masks):
    alone = add_noise(masks, SegmentationNoise(missing=0.2), seed=9)
    together = add_noise(masks, SegmentationNoise(missing=0.2, specks=4, holes=2), seed=9)
    np.testing.assert_array_equal(
        alone.any(axis=(1, 2)),
        together.any(axis=(1, 2)),
    )


def test_scaling():
    noise = SegmentationNoise(specks=1, holes=2, cut_limbs=1, missing=0.6, occluder=(0, 0, 5, 5))
    assert noise.scaled(1.0) == noise
    assert noise.scaled(0.0) == SegmentationNoise()
    double = noise.scaled(2)
    assert (double.specks, double.holes, double.cut_limbs, double.missing) == (2, 4, 2, 1.0)
    assert noise.scaled(100).cut_limbs == len(LIMB_REGIONS)


def test_more_noise_means_more_components(masks):
    levels = [
        np.mean([components(mask) for mask in add_noise(masks, CASIA_LIKE.scaled(x), seed=1)])
        for x in (0, 1, 4)
    ]
    assert levels[0] == 1
    assert levels[0] < levels[1] < levels[2]


def test_black_frames_are_left_alone():
    black = np.zeros((5, 40, 30), np.uint8)
    noise = SegmentationNoise(holes=3, cut_limbs=4, missing=0.2)
    assert not add_noise(black, noise, seed=1).any()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda masks: SegmentationNoise(specks=-1), "specks is -1"),
        (lambda masks: SegmentationNoise(holes=math.nan), "holes is nan"),
        (lambda masks: SegmentationNoise(speck_size=3), "speck_size is 3"),
        (lambda masks: SegmentationNoise(speck_size=(4, 2)), "speck_size's greatest is 2"),
        (lambda masks: SegmentationNoise(hole_size=(0, 2)), "hole_size's least is 0"),
        (lambda masks: SegmentationNoise(cut_limbs=5), "cut_limbs is 5"),
        (lambda masks: SegmentationNoise(cut_limbs=0.5), "cut_limbs is 0.5"),
        (lambda masks: SegmentationNoise(cut_share=1.5), "cut_share is 1.5"),
        (lambda masks: SegmentationNoise(missing=1.1), "missing is 1.1"),
        (lambda masks: SegmentationNoise(occluder=(0, 0, 5)), "occluder is"),
        (lambda masks: SegmentationNoise(occluder=(0, 0, 0, 5)), "occluder's width is 0"),
        (lambda masks: CASIA_LIKE.scaled(-1), "level is -1"),
        (lambda masks: add_noise(masks, None, seed=1), "noise is a NoneType"),
        (lambda masks: add_noise(masks, CASIA_LIKE, seed=-1), "seed is -1"),
        (lambda masks: add_noise(masks[0], CASIA_LIKE, seed=1), "masks is uint8 of shape"),
        (lambda masks: add_noise(masks > 0, CASIA_LIKE, seed=1), "masks is bool"),
        (lambda masks: add_noise([1, 2], CASIA_LIKE, seed=1), "masks is list"),
        (lambda masks: add_noise(masks[:0], CASIA_LIKE, seed=1), "at least one image"),
        (lambda masks: add_noise(masks // 255, CASIA_LIKE, seed=1), "other than 0 and 255"),
        (
            lambda masks: add_noise(masks, SegmentationNoise(occluder=(400, 0, 9, 9)), seed=1),
            "occluder begins at",
        ),
        (
            lambda masks: add_noise(masks[:, :3], SegmentationNoise(specks=1), seed=1),
            "make the specks smaller",
        ),
    ],
)
def test_impossible_arguments_are_refused(masks, call, message):
    with pytest.raises(ArgumentError, match=message):
        call(masks)
