"""Camera places by votes, against known walks, hand-counted histograms and drawn lines."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from mcnlab.cameras.floor import GridMap
from mcnlab.errors import ArgumentError
from mcnlab.placement.cells import (
    BINS,
    DIRECTED,
    NO_LOCUS,
    DirectedCells,
    direct_cells,
    grow_band,
    histograms,
    orientations,
    path_band,
)
from mcnlab.placement.votes import (
    VoteRules,
    choose_places,
    find_humps,
    hump_error,
    place_by_votes,
    shifted_grids,
    vote,
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


def arcs(x, y, radii, start, stop):
    """Concentric walks around (x, y)."""
    turn = np.linspace(start, stop, 60)
    return [np.stack([x + r * np.cos(turn), y + r * np.sin(turn)], axis=1) for r in radii]


def wander(seed, size, walkers=6):
    """Random walks over a map, no place on a pixel's edge."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(0, size, (walkers, 2, 1, 2))
    share = np.linspace(0, 1, 30)[:, None]
    sway = rng.normal(0, 0.05, (walkers, 30, 2)).cumsum(axis=1)
    return list(ends[:, 0] * (1 - share) + ends[:, 1] * share + sway)


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


# Votes


def draw(shape, row, column, slope_index, orientations):
    """The cells of the digital line through one cell, one at a time."""
    rows, columns = shape
    angle = np.pi * slope_index / orientations
    steep = np.pi / 4 + 1e-9 < angle < 3 * np.pi / 4 - 1e-9
    slope = 1 / np.tan(angle) if steep else np.tan(angle)
    slope = round(slope) if abs(abs(slope) - 1) < 1e-9 else slope
    length, width = (rows, columns) if steep else (columns, rows)
    along, across = (row, column) if steep else (column, row)
    middle = (length - 1) / 2

    def height(at):
        return int(np.floor((at - middle) * slope + 0.5))

    line = [(at, across + height(at) - height(along)) for at in range(length)]
    line = [(at, off) for at, off in line if 0 <= off < width]
    return [(at, off) if steep else (off, at) for at, off in line]


@given(bin_maps, st.sampled_from([8, 16, 64]), st.sampled_from(["cells", "traces"]), seeds)
def test_votes_are_those_of_lines_drawn_one_by_one(bins, orientations, weights, seed):
    magnitude = np.random.default_rng(seed).integers(1, 9, bins.shape)
    cells = directed(bins, magnitude)
    expected = np.zeros(bins.shape, int)
    for row, column in zip(*np.nonzero(bins >= 0), strict=True):
        k = (bins[row, column] + BINS // 2) % BINS * (orientations // BINS)
        line = draw(bins.shape, row, column, k, orientations)
        assert (row, column) in line
        for at in line:
            expected[at] += magnitude[row, column] if weights == "traces" else 1
    votes = vote(cells, weights=weights, orientations=orientations)
    assert votes.dtype.kind == "i"
    assert np.array_equal(votes, expected)


@pytest.mark.parametrize("orientations", [8, 64])
@pytest.mark.parametrize("shape", [(20, 31), (31, 20)])
def test_a_perpendicular_is_within_a_cell_and_without_a_gap(shape, orientations):
    rng = np.random.default_rng(0)
    for k in range(orientations):
        row, column = (int(rng.integers(side // 3, 2 * side // 3)) for side in shape)
        cells = directed(np.full(shape, -1))
        cells.kind[row, column], cells.magnitude[row, column] = DIRECTED, 1
        cells.angle[row, column] = angle = k * np.pi / orientations
        at = np.argwhere(vote(cells, orientations=orientations) == 1)
        along_walk = (at[:, 1] - column) * np.cos(angle) + (at[:, 0] - row) * np.sin(angle)
        # Two roundings of at most half a cell each, along an axis.
        assert np.abs(along_walk).max() <= 1
        assert len(at) >= min(shape) / 2  # from its middle third, both ways to the edges
        drawn = np.zeros(shape, bool)
        drawn[tuple(at.T)] = True
        assert ndimage.label(drawn, np.ones((3, 3)))[1] == 1


@given(bin_maps)
def test_votes_mirror_and_turn_with_the_scene(bins):
    votes = vote(directed(bins))
    mirrored = np.where(bins >= 0, -bins % BINS, -1)
    assert np.array_equal(vote(directed(mirrored[:, ::-1])), votes[:, ::-1])
    assert np.array_equal(vote(directed(mirrored[::-1])), votes[::-1])
    assert np.array_equal(vote(directed(bins[::-1, ::-1])), votes[::-1, ::-1])
    turned = np.where(bins >= 0, (bins + BINS // 2) % BINS, -1)
    assert np.array_equal(vote(directed(np.rot90(turned, -1))), np.rot90(votes, -1))


@given(bin_maps, seeds)
def test_votes_add_up_over_cells(bins, seed):
    cells = directed(bins)
    half = np.random.default_rng(seed).random(bins.shape) < 0.5
    parts = [part for part in (half, ~half) if (part & (bins >= 0)).any()]
    assert np.array_equal(sum(vote(cells, band=part) for part in parts), vote(cells))


def test_a_straight_corridor_votes_for_both_its_sides():
    bins = np.full((9, 20), -1)
    bins[4, 5:15] = 0
    votes = vote(directed(bins))
    assert (votes[:, 5:15] == 1).all()
    assert votes.sum() == 9 * 10


@pytest.mark.parametrize(
    ("cells", "options", "word"),
    [
        (direct_cells(np.ones((3, 4, BINS), int)), {}, "12 are chaos; raise chaos_ratio"),
        (direct_cells(np.zeros((3, 4, BINS), int)), {}, "nobody crosses"),
        (directed([[0, 1]]), {"band": np.zeros((1, 2), bool)}, "no directed cell"),
        (directed([[0, 1]]), {"band": np.ones((2, 1), bool)}, "band has the shape"),
        (directed([[0, 1]]), {"weights": "walkers"}, "weights"),
        (directed([[0, 1]]), {"orientations": 12}, "multiple of 8"),
        (directed([[0, 1]]), {"orientations": 2048}, "at most 1024"),
        (directed([[0, 1]]), {"orientations": 0}, "orientations"),
    ],
)
def test_what_cannot_vote_is_refused(cells, options, word):
    with pytest.raises(ArgumentError, match=word):
        vote(cells, **options)


# Humps and places (Figure 2.11)


def cones(shape, *peaks):
    """A landscape of cones: (row, column, height)."""
    row, column = np.indices(shape)
    return np.max(
        [np.maximum(height - np.hypot(row - r, column - c), 0) for r, c, height in peaks], axis=0
    )


def cells_of(places):
    """The cells of a table of places."""
    return list(zip(places["row"], places["column"], strict=True))


def test_humps_are_found_by_height():
    grid = GridMap(-1.0, 2.0, 20, 40, 0.5)
    humps = find_humps(cones((20, 40), (5, 8, 6.0), (14, 30, 9.0)), grid)
    assert cells_of(humps) == [(14, 30), (5, 8)]
    assert humps["votes"].tolist() == [9, 6]
    # A cell's centre is half a cell from its corner.
    assert humps["x"].tolist() == [-1 + 30.5 * 0.5, -1 + 8.5 * 0.5]
    assert humps["y"].tolist() == [2 + 14.5 * 0.5, 2 + 5.5 * 0.5]


def test_a_shoulder_that_does_not_stand_out_is_no_hump():
    votes = np.array([[0, 10, 8, 9, 0, 5, 0]])
    grid = GridMap(0, 0, 1, 7, 1.0)
    # The 9 stands 1 above the way to the 10, the 5 stands 5 above the ground.
    assert cells_of(find_humps(votes, grid, rules=VoteRules(prominence=0.2))) == [(0, 1), (0, 5)]
    assert cells_of(find_humps(votes, grid, rules=VoteRules(prominence=0.09))) == [
        (0, 1),
        (0, 3),
        (0, 5),
    ]
    assert cells_of(find_humps(votes, grid, rules=VoteRules(prominence=0.6))) == [(0, 1)]


def test_of_near_humps_the_higher_remains():
    votes = np.array([[0, 9, 0, 10, 0, 0, 9]])
    grid = GridMap(0, 0, 1, 7, 1.0)
    assert cells_of(find_humps(votes, grid, rules=VoteRules(separation=2))) == [
        (0, 3),
        (0, 1),
        (0, 6),
    ]
    assert cells_of(find_humps(votes, grid, rules=VoteRules(separation=2.5))) == [(0, 3), (0, 6)]


@pytest.mark.parametrize("top", [(slice(0, 11), slice(0, 11)), (slice(3, 8), slice(1, 10))])
def test_a_plateau_is_one_hump_at_its_middle(top):
    votes = np.zeros((11, 11), int)
    votes[top] = 7
    assert cells_of(find_humps(votes, GridMap(0, 0, 11, 11, 1.0))) == [(5, 5)]


def test_a_hump_lies_on_its_plateau_even_where_that_is_a_ring():
    votes = np.full((9, 9), 5)
    votes[1:8, 1:8] = 9
    votes[3:6, 3:6] = 8
    (at,) = cells_of(find_humps(votes, GridMap(0, 0, 9, 9, 1.0)))
    assert votes[at] == 9


def test_forbidden_cells_drop_out_and_their_neighbours_take_over():
    votes = cones((20, 20), (10, 10, 8.0))
    forbidden = np.zeros((20, 20), bool)
    forbidden[10, 10] = True
    places = choose_places(votes, GridMap(0, 0, 20, 20, 0.5), 1, forbidden=forbidden)
    assert places["votes"][0] == 7
    forbidden[:, :15] = True
    (at,) = cells_of(choose_places(votes, GridMap(0, 0, 20, 20, 0.5), 1, forbidden=forbidden))
    assert at == (10, 15)


def test_smoothing_joins_what_noise_parts():
    rng = np.random.default_rng(0)
    row, column = np.indices((40, 40))
    hill = 20 * np.exp(-((row - 20) ** 2 + (column - 20) ** 2) / 100)
    votes = np.round(hill + rng.uniform(0, 6, hill.shape)).astype(int)
    grid = GridMap(0, 0, 40, 40, 0.5)
    rough = find_humps(votes, grid, rules=VoteRules(prominence=0.1, separation=0))
    smooth = find_humps(votes, grid, rules=VoteRules(prominence=0.1, separation=0, smooth=1.5))
    assert len(rough) > len(smooth) == 1
    at = cells_of(smooth)[0]
    assert smooth["votes"][0] == votes[at]  # as counted, not as smoothed
    # The noise, ±3 with deviation √3, averages over 4π·3² cells to 0.16; the hill is that much
    # lower within 20(1 − exp(−r²/109)) = 3·0.16, r = 1.6 cells.
    assert np.hypot(at[0] - 20, at[1] - 20) <= 2


@given(
    arrays(int, (6, 7), elements=st.integers(0, 9)).filter(np.any),
    st.sampled_from([0.0, 1.0, 2.5]),
    st.sampled_from([0.01, 0.3, 1.0]),
)
def test_the_first_hump_is_the_highest_and_humps_keep_apart(votes, separation, prominence):
    grid = GridMap(0, 0, 6, 7, 1.0)
    humps = find_humps(votes, grid, rules=VoteRules(separation=separation, prominence=prominence))
    assert humps["votes"][0] == votes.max()
    assert (np.diff(humps["votes"]) <= 0).all()
    assert (humps["votes"] >= prominence * votes.max() - 1e-9).all()
    at = humps[["row", "column"]].to_numpy()
    apart = np.hypot(*(at[:, None] - at).T)
    assert len(set(cells_of(humps))) == len(humps)
    assert (apart[~np.eye(len(at), dtype=bool)] >= separation).all()


def test_places_beyond_the_humps_are_the_best_cells_apart():
    votes = cones((9, 20), (4, 4, 9.0), (4, 15, 5.0))
    grid = GridMap(0, 0, 9, 20, 1.0)
    places = choose_places(votes, grid, 4, rules=VoteRules(separation=3))
    assert cells_of(places)[:2] == [(4, 4), (4, 15)]
    assert places["votes"].tolist() == [9, 5, 6, 6]
    at = places[["row", "column"]].to_numpy()
    assert min(np.hypot(*(a - b)) for i, a in enumerate(at) for b in at[:i]) >= 3


def test_too_many_cameras_are_refused_with_the_number_of_places():
    votes = np.array([[5, 1, 0, 4, 0, 0, 3]])
    grid = GridMap(0, 0, 1, 7, 1.0)
    with pytest.raises(ArgumentError, match="n is 4, but only 3 allowed places"):
        choose_places(votes, grid, 4, rules=VoteRules(separation=2))
    with pytest.raises(ArgumentError, match="n is 5, but only 4 allowed cells"):
        choose_places(votes, grid, 5, rules=VoteRules(separation=0))
    assert choose_places(votes, grid, 3, rules=VoteRules(separation=2))["votes"].tolist() == [
        5,
        4,
        3,
    ]


@pytest.mark.parametrize(
    ("votes", "options", "word"),
    [
        ([[1, 2]], {"forbidden": [[True, True]]}, "forbid less"),
        ([[0, 2]], {"forbidden": [[False, True]]}, "none of them with votes"),
        ([[0, 0]], {}, "none of them with votes"),
        ([[1, 2]], {"forbidden": [[True], [False]]}, "forbidden has the shape"),
        ([[1, 2]], {"forbidden": [[1, 0]]}, "forbidden is of int"),
        ([[1, np.nan]], {}, "finite"),
        ([[1, -1]], {}, "votes is -1"),
        ([1, 2], {}, "votes has the shape"),
        ([[1], [1, 2]], {}, "no number"),
        ([["one", 2]], {}, "no number"),
        ([[1, 2]], {"n": 0}, "n is 0"),
        ([[1, 2]], {"n": 1.0}, r"n is 1\.0"),
    ],
)
def test_votes_that_give_no_places_are_refused(votes, options, word):
    options = {"n": 1, **options}
    with pytest.raises(ArgumentError, match=word):
        choose_places(votes, GridMap(0, 0, 1, 2, 1.0), **options)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"chaos_ratio": 0}, "chaos_ratio"),
        ({"least_traces": 0}, "least_traces"),
        ({"refine": "yes"}, "refine"),
        ({"weights": "walkers"}, "weights"),
        ({"use_band": None}, "use_band"),
        ({"keep": -0.1}, "keep"),
        ({"separation": -1}, "separation"),
        ({"separation": np.inf}, "separation"),
        ({"prominence": 0}, "prominence"),
        ({"prominence": 2}, "prominence"),
        ({"smooth": np.nan}, "smooth"),
    ],
)
def test_rules_out_of_range_are_refused(options, word):
    with pytest.raises(ArgumentError, match=word):
        VoteRules(**options)


# The whole chapter


@pytest.mark.parametrize("refine", [False, True])
@pytest.mark.parametrize(("x", "y"), [(1.0, 1.0), (1.3, 1.7), (2.0, 2.2)])
def test_walks_around_a_point_vote_for_it(x, y, refine):
    grid = GridMap(0, 0, 24, 24, 0.5)
    walks = arcs(x, y, np.arange(5, 8, 0.2), 0, np.pi / 2)
    placement = place_by_votes(table(*walks), grid, rules=VoteRules(refine=refine))
    assert len(placement.humps) == 1
    # The inmost perpendiculars, at 5 m, miss by 5·sin(π/16) m when the direction is off by
    # half a bin; digital lines are off by a cell.  Refined, only the latter remains.
    miss = 0 if refine else 5 * np.sin(BIN / 2)
    at = placement.humps.iloc[0]
    assert np.hypot(at["x"] - x, at["y"] - y) <= miss + grid.cell


@pytest.mark.parametrize("refine", [False, True])
def test_two_bends_have_two_humps(refine):
    grid = GridMap(0, 0, 24, 48, 0.5)
    radii = np.arange(5, 8, 0.2)
    walks = arcs(2, 2, radii, 0, np.pi / 2) + arcs(22, 2, radii, np.pi / 2, np.pi)
    placement = place_by_votes(table(*walks), grid, n=2, rules=VoteRules(refine=refine))
    assert len(placement.humps) == 2
    places = placement.places.sort_values("x")
    miss = (0 if refine else 5 * np.sin(BIN / 2)) + grid.cell
    assert np.hypot(places["x"] - [2, 22], places["y"] - 2).max() <= miss


def test_places_mirror_and_turn_with_the_walks():
    grid = GridMap(0, 0, 12, 12, 0.5)
    for seed in range(5):
        walks = wander(seed, 6.0, walkers=30)
        votes = place_by_votes(table(*walks), grid).votes
        mirrored = [walk * [-1, 1] + [6, 0] for walk in walks]
        turned = [walk[:, ::-1] * [-1, 1] + [6, 0] for walk in walks]
        again = [walk[::-1] for walk in walks]
        assert np.array_equal(place_by_votes(table(*mirrored), grid).votes, votes[:, ::-1])
        assert np.array_equal(place_by_votes(table(*turned), grid).votes, np.rot90(votes, -1))
        assert np.array_equal(place_by_votes(table(*again), grid).votes, votes)


def test_only_the_thinned_band_votes_when_asked():
    grid = GridMap(0, 0, 24, 24, 0.5)
    walks = table(*arcs(1, 1, np.arange(5, 8, 0.1), 0, np.pi / 2))
    whole = place_by_votes(walks, grid)
    banded = place_by_votes(walks, grid, rules=VoteRules(use_band=True))
    assert whole.band is None
    assert banded.votes.max() < whole.votes.max()
    assert not (banded.band & ~whole.cells.directed).any()
    assert np.array_equal(banded.votes, vote(whole.cells, band=banded.band))


def test_angles_computed_once_serve_every_setting():
    grid = GridMap(0, 0, 24, 24, 0.5)
    walks = table(*arcs(1, 1, np.arange(5, 8, 0.2), 0, np.pi / 2))
    angles = orientations(walks, grid)
    for options in (
        {"rules": VoteRules(least_traces=2)},
        {"rules": VoteRules(weights="traces")},
        {"n": 3},
    ):
        pd.testing.assert_frame_equal(
            place_by_votes(None, grid, angles=angles, **options).places,
            place_by_votes(walks, grid, **options).places,
        )


def test_a_crowd_going_every_way_is_refused():
    walks = table(*(straight(k * BIN) for k in range(BINS)))
    with pytest.raises(ArgumentError, match="chaos"):
        place_by_votes(walks, ONE_CELL)


@pytest.mark.parametrize("grid", [None, (5, 5), np.zeros((3, 3)), {"rows": 3}])
def test_what_is_no_grid_is_refused(grid):
    walks = table(straight(0))
    angles = orientations(walks, ONE_CELL)
    for call in (
        lambda: place_by_votes(walks, grid),
        lambda: place_by_votes(None, grid, angles=angles),
        lambda: orientations(walks, grid),
        lambda: histograms(angles, grid),
        lambda: find_humps([[1, 2]], grid),
        lambda: choose_places([[1, 2]], grid, 1),
    ):
        with pytest.raises(ArgumentError, match=r"grid is a .*; pass a GridMap"):
            call()


@pytest.mark.parametrize("call", [vote, grow_band, path_band])
def test_what_is_no_cells_is_refused(call):
    with pytest.raises(ArgumentError, match="cells is a ndarray; pass what direct_cells gives"):
        call(np.zeros((3, 3)))


def test_a_hump_s_error_is_that_of_the_worst_best_place():
    humps = pd.DataFrame({"x": [0.0, 4.0], "y": [0.0, 3.0]})
    assert hump_error(humps, [(0, 0), (4, 3)]) == 0
    assert hump_error(humps, [(0, 1), (4, 5)]) == 2
    assert hump_error(humps[:1], [(0, 0), (4, 3)]) == 5


def test_shifted_grids_cover_the_same_ground_by_quarters_of_a_cell():
    grid = GridMap(1.0, 2.0, 4, 6, 0.5)
    grids = shifted_grids(grid)
    assert len({(one.left, one.bottom) for one in grids}) == 16
    for one in grids:
        left, bottom, right, top = one.area
        assert left <= 1.0 and bottom <= 2.0
        assert right >= grid.area[2] and top >= grid.area[3]
        assert (1.0 - left) % 0.125 == 0 and (2.0 - bottom) % 0.125 == 0
