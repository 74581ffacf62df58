"""From directed cells to where cameras should stand, as chapter 2 of the thesis does it.

Each directed cell (see `cells`) votes for all cells on the perpendicular to its direction;
the humps of the votes are the places from which walkers are seen square-on (sections 2.2.4
and 2.3, Figures 2.6 and 2.11).

References
----------
R. Raman, "Study on Models for Smart Surveillance through Multi-Camera Networks", 2013.
L. Vincent, "Morphological grayscale reconstruction in image analysis", IEEE Trans. Image
Processing 2(2), 1993 (humps by their prominence).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras.floor import GridMap, check_grid
from mcnlab.checks import require_array, require_choice, require_count, require_kind, require_number
from mcnlab.errors import ArgumentError
from mcnlab.placement.cells import (
    BINS,
    CHAOS_RATIO,
    COLUMN,
    KEEP,
    ROW,
    DirectedCells,
    direct_cells,
    histograms,
    orientations,
    path_band,
    require_directed,
    thin,
)
from mcnlab.tables import X, Y, starts_of

VOTES: Final = "votes"  # perpendiculars that pass through a cell
SEPARATION = 2.0  # m; two humps nearer than this are one place for a camera
PROMINENCE = 0.2  # of the highest hump; how far a hump must stand out
WEIGHTS: Final = ("cells", "traces")  # what a vote weighs: one, or the cell's walks
FINE = 64  # orientations of the perpendiculars to refined directions


@dataclass(frozen=True)
class VoteRules:
    """The thresholds on the way from traces to camera places.

    Attributes
    ----------
    chaos_ratio : float
        Above 0, at most 1; a rival direction that reaches this share of the highest makes
        a cell chaos (see `cells.direct_cells`).
    least_traces : int
        Walks in a bin that make a prominent maximum.
    refine : bool
        Take the mean direction of a cell's walks, not the bin's centre, and perpendiculars
        in 64 orientations, not 8: beyond the thesis.
    weights : {"cells", "traces"}
        What a directed cell adds: one, as in the thesis, or its magnitude.
    use_band : bool
        Let only the thinned path band vote, as the thesis advises when walks are many.
    keep : float
        Share of the strongest cell's magnitude that a cell of the band needs, 0 to 1.
    separation : float
        Metres; two humps nearer than this are one place.
    prominence : float
        Share of the highest hump by which a hump stands out, above 0, at most 1.
    smooth : float
        Standard deviation of the Gaussian the votes are first smoothed by, metres; 0, as
        in the thesis, does not.

    Raises
    ------
    ArgumentError
        When a threshold is out of range.
    """

    chaos_ratio: float = CHAOS_RATIO
    least_traces: int = 1
    refine: bool = False
    weights: str = "cells"
    use_band: bool = False
    keep: float = KEEP
    separation: float = SEPARATION
    prominence: float = PROMINENCE
    smooth: float = 0.0

    def __post_init__(self) -> None:
        require_number("chaos_ratio", self.chaos_ratio, above=0, high=1)
        require_count("least_traces", self.least_traces, low=1)
        require_choice("refine", self.refine, (True, False))
        require_choice("weights", self.weights, WEIGHTS)
        require_choice("use_band", self.use_band, (True, False))
        require_number("keep", self.keep, low=0, high=1)
        require_number("separation", self.separation, low=0, unit="metres")
        require_number("prominence", self.prominence, above=0, high=1)
        require_number("smooth", self.smooth, low=0, unit="metres")


RULES: Final = VoteRules()


@dataclass(frozen=True, eq=False)
class Placement:
    """Camera places by votes, with what led to them.

    Attributes
    ----------
    angles : pandas.DataFrame
        As from `orientations`.
    cells : DirectedCells
    band : ndarray of bool, shape (rows, columns), or None
        The thinned path band that voted; None when every directed cell did.
    votes : ndarray of int, shape (rows, columns)
    humps, places : pandas.DataFrame
        row, column, x, y (metres), votes; the best first.
    """

    angles: pd.DataFrame
    cells: DirectedCells
    band: np.ndarray | None
    votes: np.ndarray
    humps: pd.DataFrame
    places: pd.DataFrame


def vote(
    cells: DirectedCells,
    *,
    weights: str = "cells",
    band: ArrayLike | None = None,
    orientations: int = BINS,
) -> np.ndarray:
    """Count the perpendiculars that pass through each cell (sections 2.2.4 and 2.3).

    A perpendicular runs both ways across the whole map, its own cell included, one cell a
    step along the axis that it is nearer to.  For each orientation such digital lines part
    the map: each cell lies on just one, within a cell of its own perpendicular.  So votes are
    counted a line and read back a cell, at a cost of orientations times cells.  As each line
    enters a row (or column) once, no orientation is favoured, as touching every cell on the
    way would favour the diagonals.

    Parameters
    ----------
    cells : DirectedCells
    weights : {"cells", "traces"}, optional
        What a directed cell adds: one, as in the thesis, or its magnitude.
    band : array_like of bool, shape (rows, columns), optional
        Only these cells vote, such as a thinned path band.
    orientations : int, optional
        Perpendiculars are turned to the nearest of so many, a multiple of 8.

    Returns
    -------
    ndarray of int, shape (rows, columns)

    Raises
    ------
    ArgumentError
        When no cell is directed, or none in the band, or an argument is out of range.
    """
    require_choice("weights", weights, WEIGHTS)
    count = require_count("orientations", orientations, low=BINS)
    if count % BINS or count > 1024:
        raise ArgumentError(
            f"orientations is {count}; pass a multiple of {BINS}, at most 1024, so that each "
            "bin's centre is among them."
        )
    require_directed(cells)
    voting = cells.directed
    if band is not None:
        voting = voting & require_array("band", band, cells.shape, dtype=bool)
        if not voting.any():
            raise ArgumentError("band holds no directed cell; lower keep, or vote without it.")
    row, column = np.nonzero(voting)
    across = np.floor(cells.angle[voting] * (count / np.pi) + 0.5).astype(np.int64)
    across = ((across + count // 2) % count).astype(np.int16)  # sorted by digits
    weight = None if weights == "cells" else cells.magnitude[voting]
    order = np.argsort(across, kind="stable")
    ends = np.searchsorted(across[order], np.arange(count + 1))
    flat, steep = np.zeros(cells.shape[::-1], np.int64), np.zeros(cells.shape, np.int64)
    for k in np.flatnonzero(np.diff(ends)):
        of = order[ends[k] : ends[k + 1]]
        part = None if weight is None else weight[of]
        # A flat line is the same line turned by a quarter on the map's transpose.
        if 4 * k <= count or 4 * k >= 3 * count:
            _count_lines(flat, column[of], row[of], part, np.tan(np.pi * k / count))
        else:
            _count_lines(steep, row[of], column[of], part, np.tan(np.pi * (0.5 - k / count)))
    return steep + flat.T


def _count_lines(votes, along, across, weight, slope):
    """Add to `votes` the lines through some cells; a line's index is across − slope·along."""
    length, width = votes.shape
    # Exactly one a step on a diagonal, where a rounding error would tear the line.  Other
    # slopes are irrational, so nothing falls on a half, and the map's middle as the origin
    # makes the lines of a mirrored map the mirrored lines.
    slope = np.round(slope) if abs(abs(slope) - 1) < 1e-9 else slope
    shift = np.floor((np.arange(length) - (length - 1) / 2) * slope + 0.5).astype(np.int64)
    start = shift.max() - shift
    lines = width + int(start.max())
    sums = np.bincount(across + start[along], weight, minlength=lines).astype(np.int64)
    votes += np.lib.stride_tricks.sliding_window_view(sums, width)[start]


def find_humps(
    votes: ArrayLike, grid: GridMap, *, rules: VoteRules = RULES, forbidden: ArrayLike | None = None
) -> pd.DataFrame:
    """The humps of the votes, the best first (Figure 2.11).

    A hump stands out: to reach a higher one, one must first go down by more than the rules'
    `prominence` times the highest.  Digital lines cross in many small peaks that are none.
    Of equally high cells on a hump the one nearest to their middle is taken; of humps nearer
    than `separation` only the higher remains.

    Parameters
    ----------
    votes : array_like, shape (rows, columns)
    grid : GridMap
    rules : VoteRules, optional
        Their `separation`, `prominence` and `smooth`.
    forbidden : array_like of bool, shape (rows, columns), optional
        Where no camera can be.  These cells count as without votes.

    Returns
    -------
    pandas.DataFrame
        row, column, x, y (metres), votes (not smoothed).

    Raises
    ------
    ArgumentError
        When the votes are not a map of finite numbers on that grid, or every cell with votes
        is forbidden.
    """
    from scipy import ndimage
    from skimage.morphology import local_maxima, reconstruction

    votes, allowed = _check_votes(votes, grid, forbidden)
    surface = votes.astype(float)
    if rules.smooth > 0:
        surface = ndimage.gaussian_filter(surface, rules.smooth / grid.cell, mode="constant")
    # A rim below the ground lets a hump stand on the map's edge, or be the whole map.
    surface = np.pad(np.where(allowed, surface, 0.0), 1, constant_values=-1.0)
    eight = np.ones((3, 3))
    cut = reconstruction(surface - rules.prominence * surface.max(), surface, footprint=eight)
    region, count = ndimage.label(local_maxima(cut), eight)
    region, surface = region[1:-1, 1:-1], surface[1:-1, 1:-1]
    summit = ndimage.maximum(surface, region, np.arange(count + 1))
    row, column = np.nonzero((region > 0) & (surface >= summit[region] - 1e-9) & allowed)
    of = region[row, column]
    number = np.maximum(np.bincount(of, minlength=count + 1), 1)
    middle = [np.bincount(of, part, minlength=count + 1) / number for part in (row, column)]
    # Rounded, so that cells as far from the middle are ordered by row, whatever the rounding.
    far = np.round(np.hypot(row - middle[0][of], column - middle[1][of]), 6)
    order = np.lexsort((column, row, far, of))
    order = order[starts_of(of[order])]
    order = order[np.lexsort((column[order], row[order], -surface[row, column][order]))]
    row, column = row[order], column[order]
    kept = np.empty(0, np.int64)
    free = np.ones(len(row), bool)
    while free.any():
        best = int(np.argmax(free))
        kept = np.r_[kept, best]
        free &= np.hypot(row - row[best], column - column[best]) * grid.cell >= rules.separation
        free[best] = False
    return _place_table(row[kept], column[kept], votes, grid)


def choose_places(
    votes: ArrayLike,
    grid: GridMap,
    n: int,
    *,
    rules: VoteRules = RULES,
    forbidden: ArrayLike | None = None,
    humps: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """The best n places for cameras (section 2.3).

    The humps come first.  When they are fewer than n, the cells with most votes follow that
    are at least `separation` from every place chosen before.

    Parameters
    ----------
    votes, grid, rules, forbidden
        As in `find_humps`.
    n : int
        How many cameras there are.
    humps : pandas.DataFrame, optional
        What `find_humps` gave for the same arguments, to save finding them again.

    Returns
    -------
    pandas.DataFrame
        row, column, x, y (metres), votes; n rows, in the order of choice.

    Raises
    ------
    ArgumentError
        As in `find_humps`, and when there are not n places; the message says how many.
    """
    n = require_count("n", n, low=1)
    if humps is None:
        humps = find_humps(votes, grid, rules=rules, forbidden=forbidden)
    votes, allowed = _check_votes(votes, grid, forbidden)
    left = np.where(allowed, votes, 0)
    if n > np.count_nonzero(left):
        raise ArgumentError(
            f"n is {n}, but only {np.count_nonzero(left)} allowed cells have votes; pass a "
            "smaller n, or forbid less."
        )
    chosen = list(zip(humps[ROW], humps[COLUMN], strict=True))[:n]
    y, x = np.ogrid[: grid.rows, : grid.columns]
    radius = rules.separation / grid.cell
    for row, column in chosen:
        left[_within(x - column, y - row, radius)] = 0
    while len(chosen) < n and left.any():
        row, column = (int(at) for at in np.unravel_index(np.argmax(left), left.shape))
        chosen.append((row, column))
        left[_within(x - column, y - row, radius)] = 0
    if len(chosen) < n:
        raise ArgumentError(
            f"n is {n}, but only {len(chosen)} allowed places with votes exist at least "
            f"{rules.separation:g} m apart; pass a smaller n or separation, or forbid less."
        )
    row, column = np.array(chosen).T
    return _place_table(row, column, votes, grid)


def _within(x, y, radius):
    """Cells nearer than a radius, and the cell itself."""
    square = x**2 + y**2
    return (square < radius**2) | (square == 0)


def place_by_votes(
    traces: pd.DataFrame | None,
    grid: GridMap,
    *,
    n: int | None = None,
    rules: VoteRules = RULES,
    forbidden: ArrayLike | None = None,
    angles: pd.DataFrame | None = None,
) -> Placement:
    """From traces to camera places, the whole of the thesis's chapter 2.

    Parameters
    ----------
    traces : pandas.DataFrame
        A trace table, metres; not looked at when `angles` is passed.
    grid : GridMap
    n : int, optional
        Cameras to place; without it, one on each hump.
    rules : VoteRules, optional
    forbidden : array_like of bool, shape (rows, columns), optional
        Where no camera can be.
    angles : pandas.DataFrame, optional
        What `orientations` gave for these traces on this grid, to save computing it again.

    Returns
    -------
    Placement

    Raises
    ------
    TableError, ArgumentError
        As in the steps.

    Examples
    --------
    >>> from mcnlab.cameras import GridMap
    >>> from mcnlab.synthetic.corridor import make_corridor
    >>> scene = make_corridor(walkers=20)
    >>> placed = place_by_votes(scene.traces, GridMap.over(scene.area), n=2)
    >>> list(placed.places.columns), len(placed.places)
    (['row', 'column', 'x', 'y', 'votes'], 2)
    """
    require_kind("rules", rules, VoteRules, "VoteRules(…)")
    check_grid(grid)
    if angles is None:
        angles = orientations(traces, grid)
    cells = direct_cells(
        histograms(angles, grid),
        chaos_ratio=rules.chaos_ratio,
        least_traces=rules.least_traces,
        refine=angles if rules.refine else None,
    )
    band = thin(path_band(cells, keep=rules.keep)) if rules.use_band else None
    turns = FINE if rules.refine else BINS
    votes = vote(cells, weights=rules.weights, band=band, orientations=turns)
    places = humps = find_humps(votes, grid, rules=rules, forbidden=forbidden)
    if n is not None:
        places = choose_places(votes, grid, n, rules=rules, forbidden=forbidden, humps=humps)
    return Placement(angles, cells, band, votes, humps, places)


def _check_votes(votes, grid, forbidden):
    shape = check_grid(grid).shape
    checked = require_array("votes", votes, shape, low=0)
    votes = np.asarray(votes)
    votes = votes if votes.dtype.kind in "iu" else checked
    allowed = np.ones(shape, bool)
    if forbidden is not None:
        allowed = ~require_array("forbidden", forbidden, shape, dtype=bool)
    if not (votes[allowed] > 0).any():
        raise ArgumentError(
            f"forbidden and votes leave no place: of {votes.size} cells {allowed.sum()} are allowed"
            ", none of them with votes; forbid less, or take in more traces."
        )
    return votes, allowed


def _place_table(row, column, votes, grid):
    x, y = grid.place_of(row, column)
    return pd.DataFrame({ROW: row, COLUMN: column, X: x, Y: y, VOTES: votes[row, column]})


def hump_error(humps: pd.DataFrame, best_places: ArrayLike) -> float:
    """The farthest that any of the best places is from its nearest hump, metres."""
    apart = humps[[X, Y]].to_numpy()[:, None] - np.asarray(best_places, float)[None]
    return float(np.linalg.norm(apart, axis=2).min(axis=0).max())


def shifted_grids(grid: GridMap, *, steps: int = 4) -> list[GridMap]:
    """The same cells, shifted by parts of a cell in x and y: steps² grids that cover it all."""
    steps = require_count("steps", steps, low=1)
    return [
        GridMap(
            grid.left - across * grid.cell / steps,
            grid.bottom - up * grid.cell / steps,
            grid.rows + (up > 0),
            grid.columns + (across > 0),
            grid.cell,
        )
        for across in range(steps)
        for up in range(steps)
    ]
