"""Directions in cells, against drawings and the thesis's words."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from mcnlab.cameras.floor import GridMap
from mcnlab.errors import ArgumentError, TableError
from mcnlab.placement.cells import (
    BINS,
    CHAOS,
    DIRECTED,
    NO_LOCUS,
    DirectedCells,
    direct_cells,
    example_patterns,
    grow_band,
    histograms,
    infer_angle,
    orientations,
    path_band,
    thin,
)

BIN = np.pi / BINS
ONE_CELL = GridMap(0, 0, 1, 1, 1.0)
shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))
seeds = st.integers(0, 2**32 - 1)


def table(*walks):
    """A trace table from (n, 2) arrays of places."""
    return pd.concat(
        [
            pd.DataFrame(
                {"trace": f"walk-{k}", "frame": range(len(at)), "x": at[:, 0], "y": at[:, 1]}
            )
            for k, at in enumerate(map(np.asarray, walks))
        ],
        ignore_index=True,
    )


def straight(angle, *, through=(0.5, 0.5), half=1.0):
    """A straight walk of two sightings."""
    step = half * np.array([np.cos(angle), np.sin(angle)])
    return np.array([through - step, through + step])


def wander(seed, size, walkers=6):
    """Random walks over a map, no place on a pixel's edge."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(0, size, (walkers, 2, 1, 2))
    share = np.linspace(0, 1, 30)[:, None]
    sway = rng.normal(0, 0.05, (walkers, 30, 2)).cumsum(axis=1)
    return list(ends[:, 0] * (1 - share) + ends[:, 1] * share + sway)


def off_by(angle, truth):
    """The angle between two undirected directions."""
    return np.abs((np.asarray(angle) - truth + np.pi / 2) % np.pi - np.pi / 2)


def counts(*bins):
    """The histogram of one cell."""
    return np.array(bins).reshape(1, 1, BINS)


def directed(bins, magnitude=None):
    """Cells that all have a direction, given by bin; −1 for none."""
    bins = np.asarray(bins)
    kind = np.where(bins >= 0, DIRECTED, NO_LOCUS)
    magnitude = np.where(bins >= 0, 1 if magnitude is None else magnitude, 0)
    angle = np.where(bins >= 0, bins * BIN, 0.0)
    return DirectedCells(kind, angle, magnitude, np.zeros((*bins.shape, BINS), int))


bin_maps = shapes.flatmap(
    lambda shape: arrays(int, shape, elements=st.integers(-1, BINS - 1))
).filter(lambda bins: (bins >= 0).any())


# Angles from pixels (Figure 2.4)


def test_strokes_are_read_at_their_angle_and_shapeless_patterns_are_not():
    patterns = example_patterns()
    assert len(patterns) >= BINS + 3
    angle, known = infer_angle(np.array(list(patterns.values())))
    assert known.tolist() == [name.endswith("π/8") for name in patterns]
    # A stroke one pixel wide is off its line by half a pixel at most, so by ½Σ|u|/Σu² in
    # slope, u its pixels from −3.5 to 3.5: 8/42, of which the bin's half, tan(π/16), is more.
    assert np.tan(BIN / 2) > 8 / 42
    assert off_by(angle[:BINS], np.arange(BINS) * BIN).max() <= np.arctan(8 / 42)
    assert (angle[~known] == 0).all()


def test_strokes_along_axes_and_diagonals_are_read_exactly():
    patterns = example_patterns()
    for k in (0, 2, 4, 6):
        assert infer_angle(patterns[f"{k}π/8"]).angle == pytest.approx(k * BIN, abs=1e-12)


@given(arrays(bool, (8, 8)))
def test_an_angle_turns_and_mirrors_with_its_pattern(pattern):
    angle, known = infer_angle(pattern)
    turned, mirrored = infer_angle(np.rot90(pattern, -1)), infer_angle(pattern[:, ::-1])
    assert known == turned.known == mirrored.known
    if known:
        # Rows count upwards, so numpy's quarter clockwise is anticlockwise on the map.
        assert off_by(turned.angle, angle + np.pi / 2) < 1e-9
        assert off_by(mirrored.angle, -angle) < 1e-9


@pytest.mark.parametrize("pattern", [np.zeros((8, 8)), np.zeros((7, 8), bool), np.array(True)])
def test_other_patterns_are_refused(pattern):
    with pytest.raises(ArgumentError, match="patterns"):
        infer_angle(pattern)


# Traces to angles


@pytest.mark.parametrize("k", range(BINS))
def test_a_straight_walk_is_read_at_its_angle(k):
    rng = np.random.default_rng(k)
    walks = [straight(k * BIN, through=0.5 + rng.uniform(-0.1, 0.1, 2)) for _ in range(50)]
    angles = orientations(table(*walks), ONE_CELL)
    assert len(angles) == 50
    # Marked pixels' centres lie within d = (|cos| + |sin|)/2 pixels of the walk.  With u along
    # and v across it, tan 2φ = 2 cov(u, v)/(var u − var v) ≤ 2d·mean|u|/(var u − d²), where a
    # chord of L pixels has mean|u| = L/4 and var u = L²/12.
    d = (abs(np.cos(k * BIN)) + abs(np.sin(k * BIN))) / 2
    chord = 8 / max(abs(np.cos(k * BIN)), abs(np.sin(k * BIN))) - 2 * 0.2 * 8 * (k % 4 != 0)
    bound = 0.5 * np.arctan2(d * chord / 2, chord**2 / 12 - d**2)
    assert bound < BIN
    assert off_by(angles["angle"], k * BIN).max() <= bound
    assert histograms(angles, ONE_CELL)[0, 0, k] >= 45


def test_a_fast_walker_leaves_no_hole_but_a_lost_one_does():
    grid = GridMap(0, 0, 1, 20, 0.5)
    walk = np.array([[0.01, 0.2], [1.9, 0.2], [3.8, 0.2], [8.2, 0.2], [9.9, 0.2]])
    crossed = orientations(table(walk), grid)["column"].tolist()
    assert crossed == [*range(8), *range(16, 20)]
    assert orientations(table(walk), grid, bridge=5)["column"].tolist() == list(range(20))


def test_traces_are_not_joined_to_one_another():
    walks = np.array([[0.01, 0.2], [0.99, 0.2]]), np.array([[1.51, 0.2], [2.49, 0.2]])
    angles = orientations(table(*walks), GridMap(0, 0, 1, 5, 0.5))
    assert list(zip(angles["trace"], angles["column"], strict=True)) == [
        ("walk-0", 0),
        ("walk-0", 1),
        ("walk-1", 3),
        ("walk-1", 4),
    ]


def test_a_walker_who_comes_back_has_one_vote():
    there = np.array([[0.1, 0.5], [0.9, 0.5], [1.8, 0.5]])
    angles = orientations(table(np.vstack([there, there[::-1]])), ONE_CELL)
    assert len(angles) == 1


def test_who_lingers_shows_no_direction():
    rng = np.random.default_rng(0)
    linger = rng.uniform(0.1, 0.9, (200, 2))
    angles = orientations(table(linger, straight(0.0)), ONE_CELL)
    assert angles["trace"].tolist() == ["walk-1"]


def test_the_sense_of_walking_does_not_matter():
    grid = GridMap(0, 0, 12, 12, 0.5)
    for seed in range(20):
        walks = wander(seed, 6.0)
        # Sampled on pixels' edges, where the least difference shows: 1/49 of 49 is below 1.
        walks.append(np.array([[0.0, seed / 7], [49.0, 20.0]]) / 16)
        there = orientations(table(*walks), grid, bridge=5)
        back = orientations(table(*(walk[::-1] for walk in walks)), grid, bridge=5)
        pd.testing.assert_frame_equal(there, back)


@given(st.integers(0, 99), st.sampled_from([0.125, 0.5, 2.0, 8.0]))
@settings(max_examples=20)
def test_metres_and_cells_may_be_scaled_together(seed, scale):
    walks = wander(seed, 6.0)
    plain = orientations(table(*walks), GridMap(0, 0, 12, 12, 0.5))
    # Powers of two, so that no place moves over a pixel's edge by rounding.
    scaled = orientations(
        table(*(scale * walk for walk in walks)),
        GridMap(0, 0, 12, 12, 0.5 * scale),
        bridge=2.0 * scale,
    )
    pd.testing.assert_frame_equal(plain, scaled)


def test_what_lies_outside_the_map_is_cut_off():
    grid = GridMap(0, 0, 1, 4, 0.5)
    whole = orientations(table([[-1.5, 0.25], [0.4, 0.25], [1.9, 0.25], [3.5, 0.25]]), grid)
    inner = orientations(table([[0.0, 0.25], [0.4, 0.25], [1.9, 0.25], [1.999, 0.25]]), grid)
    pd.testing.assert_frame_equal(whole, inner)


def test_traces_all_outside_the_map_are_refused():
    with pytest.raises(ArgumentError, match="none of the 2 touches the map"):
        orientations(table(straight(0, through=(9, 9)), straight(1, through=(-9, 0))), ONE_CELL)


def test_traces_of_people_who_stand_are_refused():
    with pytest.raises(ArgumentError, match="none shows a direction"):
        orientations(table(np.full((5, 2), 0.5)), ONE_CELL)


def test_cells_too_small_for_the_traces_are_refused():
    with pytest.raises(ArgumentError, match="cells too small"):
        orientations(table(straight(0.3, through=(0, 0))), GridMap(0, 0, 1000, 1000, 1e-9))


@pytest.mark.parametrize("bridge", [-1, np.nan, "2"])
def test_a_senseless_bridge_is_refused(bridge):
    with pytest.raises(ArgumentError, match="bridge"):
        orientations(table(straight(0)), ONE_CELL, bridge=bridge)


@pytest.mark.parametrize(
    ("change", "error", "word"),
    [
        ({"angle": np.pi}, ArgumentError, r"\[0, π\)"),
        ({"angle": np.nan}, ArgumentError, r"\[0, π\)"),
        ({"row": 3}, ArgumentError, "on the grid of 1×1"),
        ({"column": -1}, ArgumentError, "on the grid of 1×1"),
        ({"row": 0.5}, ArgumentError, "whole"),
        (None, TableError, "lacks"),
    ],
)
def test_angles_that_do_not_fit_are_refused(change, error, word):
    angles = orientations(table(straight(0)), ONE_CELL)
    angles = angles.drop(columns="angle") if change is None else angles.assign(**change)
    with pytest.raises(error, match=word):
        histograms(angles, ONE_CELL)


# Histograms to directed cells (Figures 2.5 and 2.10)


def test_bins_are_centred_and_circular():
    angle = np.array([0.0, BIN / 2 - 1e-9, BIN / 2 + 1e-9, np.pi / 2, np.pi - 1e-9])
    angles = pd.DataFrame({"trace": "a", "row": 0, "column": 0, "angle": angle})
    assert histograms(angles, ONE_CELL)[0, 0].tolist() == [3, 1, 0, 0, 1, 0, 0, 0]


def test_fifteen_walks_one_way_make_a_directed_cell():
    # Figure 2.10: fifteen walks with a proper orientation.
    cells = direct_cells(counts(0, 1, 3, 9, 2, 0, 0, 0))
    assert cells.kind[0, 0] == DIRECTED
    assert cells.angle[0, 0] == pytest.approx(3 * BIN)
    assert cells.magnitude[0, 0] == 9


@pytest.mark.parametrize(
    ("histogram", "kind"),
    [
        (counts(2, 2, 2, 2, 2, 2, 2, 2), CHAOS),
        (counts(0, 0, 0, 0, 0, 0, 0, 0), NO_LOCUS),
        (counts(10, 0, 0, 8, 0, 0, 0, 0), CHAOS),
        (counts(10, 0, 0, 7, 0, 0, 0, 0), DIRECTED),
        (counts(10, 10, 0, 0, 0, 0, 0, 0), DIRECTED),
        (counts(10, 0, 0, 0, 0, 0, 0, 9), DIRECTED),
        (counts(10, 0, 0, 0, 0, 0, 9, 0), CHAOS),
        (counts(1, 0, 0, 0, 0, 0, 0, 0), DIRECTED),
    ],
)
def test_chaos_is_a_rival_that_is_no_neighbour(histogram, kind):
    cells = direct_cells(histogram)
    assert cells.kind[0, 0] == kind
    if kind != DIRECTED:
        assert cells.magnitude[0, 0] == cells.angle[0, 0] == 0


def test_a_maximum_below_the_least_number_of_walks_is_not_prominent():
    histogram = counts(0, 4, 0, 0, 0, 0, 0, 0)
    assert direct_cells(histogram, least_traces=4).kind[0, 0] == DIRECTED
    assert direct_cells(histogram, least_traces=5).kind[0, 0] == CHAOS


@pytest.mark.parametrize("ratio", [0.07, 0.3, 0.55, 0.57, 0.8])  # 0.55·100 is 55.00000000000001
def test_a_rival_at_the_very_ratio_is_chaos(ratio):
    rival = round(100 * ratio)
    assert direct_cells(counts(100, 0, 0, rival, 0, 0, 0, 0), chaos_ratio=ratio).kind[0, 0] == CHAOS


@given(arrays(int, (3, 3, BINS), elements=st.integers(0, 12)), st.floats(0.05, 1))
def test_the_rule_is_the_thesis_word_for_word(histogram, ratio):
    cells = direct_cells(histogram, chaos_ratio=ratio)
    for at in np.ndindex(3, 3):
        bins = histogram[at]
        verdicts = set()
        for top in np.flatnonzero(bins == bins.max()):
            others = [bins[k] for k in range(BINS) if (k - top) % BINS not in (0, 1, BINS - 1)]
            verdicts.add(CHAOS if max(others) >= ratio * bins.max() - 1e-9 else DIRECTED)
        # Which of two equal bins is the highest is ours to say, so either verdict is right.
        assert cells.kind[at] in ({NO_LOCUS} if bins.max() == 0 else verdicts)


@given(arrays(int, (1, 1, BINS), elements=st.integers(0, 3)))
def test_equal_bins_are_decided_alike_in_a_mirror_and_after_a_quarter(histogram):
    plain = direct_cells(histogram)
    for changed, angle in (
        (np.roll(histogram[..., ::-1], 1, axis=-1), -plain.angle),
        (np.roll(histogram, 4, axis=-1), plain.angle + np.pi / 2),
    ):
        other = direct_cells(changed)
        assert other.kind == plain.kind
        if plain.kind == DIRECTED:
            assert off_by(other.angle, angle) < 1e-9


def test_a_refined_angle_is_the_mean_of_the_walks_in_and_beside_the_highest_bin():
    truth = np.array([0.05, -0.1, 0.15, -0.3, 0.02]) % np.pi
    stray = np.array([1.5])
    angle = np.r_[truth, stray]
    angles = pd.DataFrame({"trace": "a", "row": 0, "column": 0, "angle": angle})
    counted = histograms(angles, ONE_CELL)
    assert direct_cells(counted).angle[0, 0] == 0
    mean = 0.5 * np.angle(np.exp(2j * truth).sum()) % np.pi
    assert direct_cells(counted, refine=angles).angle[0, 0] == pytest.approx(mean)
    with pytest.raises(ArgumentError, match="refine"):
        direct_cells(counted, refine=angles[:3])


@pytest.mark.parametrize(
    ("histogram", "options", "word"),
    [
        (np.zeros((2, 2, 7), int), {}, "histograms"),
        (np.full((2, 2, BINS), 0.5), {}, "histograms is 0.5"),
        (np.zeros((0, 2, BINS), int), {}, "empty map"),
        (counts(-1, 0, 0, 0, 0, 0, 0, 0), {}, "histograms is -1"),
        (counts(1, 0, 0, 0, 0, 0, 0, 0), {"chaos_ratio": 0}, "chaos_ratio"),
        (counts(1, 0, 0, 0, 0, 0, 0, 0), {"chaos_ratio": 1.01}, "chaos_ratio"),
        (counts(1, 0, 0, 0, 0, 0, 0, 0), {"chaos_ratio": np.nan}, "chaos_ratio"),
        (counts(1, 0, 0, 0, 0, 0, 0, 0), {"least_traces": 0}, "least_traces"),
        (counts(1, 0, 0, 0, 0, 0, 0, 0), {"least_traces": 1.5}, "least_traces"),
    ],
)
def test_histograms_and_thresholds_out_of_range_are_refused(histogram, options, word):
    with pytest.raises(ArgumentError, match=word):
        direct_cells(histogram, **options)


# Path band (Figure 2.6)


@given(
    shapes.flatmap(lambda shape: arrays(int, shape, elements=st.integers(0, 6))).filter(np.any),
    st.sampled_from([0.0, 0.3, 0.5, 1.0]),
)
def test_the_band_is_what_hangs_together_with_the_strongest(magnitude, keep):
    cells = directed(np.where(magnitude > 0, 0, -1), magnitude)
    strong = (magnitude > 0) & (magnitude >= keep * magnitude.max())
    label, _ = ndimage.label(strong, np.ones((3, 3)))
    expected = np.isin(label, label[magnitude == magnitude.max()])
    assert np.array_equal(path_band(cells, keep=keep), expected)


def test_the_band_grows_by_one_ring_a_step():
    magnitude = np.full((5, 7), 2)
    magnitude[2, 1] = 3
    steps = grow_band(directed(np.zeros((5, 7), int), magnitude))
    row, column = np.indices((5, 7))
    assert np.array_equal(steps, np.maximum(np.abs(row - 2), np.abs(column - 1)))


def test_a_thinned_band_is_a_line_within_it():
    band = np.zeros((9, 30), bool)
    band[2:7, 1:29] = True
    line = thin(band)
    assert not (line & ~band).any()
    assert (line.sum(axis=0)[4:26] == 1).all()
    with pytest.raises(ArgumentError, match="band holds no cell"):
        thin(np.zeros((3, 3), bool))


@pytest.mark.parametrize("keep", [-0.1, 1.1, np.nan])
def test_a_senseless_share_to_keep_is_refused(keep):
    with pytest.raises(ArgumentError, match="keep"):
        path_band(directed([[0]]), keep=keep)
