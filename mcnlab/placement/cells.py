"""Where people walk in which direction: the cells of the grid map (thesis section 2.2).

Each trace's direction is read in each cell from its pixels there; the cell's histogram of
directions makes it directed, chaos, or empty; the path band grows over the directed ones
(sections 2.2.2, 2.2.3 and 2.3, Figures 2.3–2.5, 2.6(a) and 2.10).

The steps are separate functions, so that a changed threshold repeats only what follows it.
Angles are radians in [0, π), anticlockwise from x: walks there and back are one direction.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras.floor import MAP_PIXELS, GridMap, check_grid
from mcnlab.checks import require_array, require_count, require_kind, require_number
from mcnlab.errors import ArgumentError
from mcnlab.tables import TRACE, X, Y, check_columns, check_traces, starts_of

ROW: Final = "row"  # a cell's row on the grid map, 0 the lowest
COLUMN: Final = "column"  # a cell's column, 0 the leftmost
ANGLE: Final = "angle"  # a trace's direction in a cell, radians in [0, π)
ANGLE_COLUMNS: Final = (TRACE, ROW, COLUMN, ANGLE)
BINS: Final = 8  # of π/8 each (section 2.2.2)
NO_LOCUS, DIRECTED, CHAOS = 0, 1, 2  # the kinds of cell (Figure 2.5)
CHAOS_RATIO = 0.8  # section 2.3
# Fewer pixels are a clipped corner of the cell, and tell more of the pixels than of the walk:
# of random straight walks, those that mark five are read within half a bin 98 times in 100,
# those that mark four 92 times, three 72 times.
LEAST_PIXELS = 5
# (λ1 − λ2)/(λ1 + λ2) of the pixels' covariance: 1 a line, 0 a disc, a square or a cross.  At
# one half the pixels spread √3 times as far along the walk as across it; someone who lingers
# fills the cell and stays below.
LEAST_ELONGATION = 0.5
BRIDGE = 2.0  # m between two sightings; farther apart, nobody knows how the walker went
MOST_SAMPLES = 20_000_000  # points along all traces; more is a mistake in units
KEEP = 0.25  # of the strongest cell's magnitude; the thesis gives no number


class PatternAngle(NamedTuple):
    """The angles of pixel patterns."""

    angle: np.ndarray  # radians in [0, π); 0 where there is none
    known: np.ndarray  # whether the pattern shows a direction


@dataclass(frozen=True, eq=False)
class DirectedCells:
    """What kind of cell each is, and where its walkers go (Figures 2.5 and 2.10).

    Attributes
    ----------
    kind : ndarray of int, shape (rows, columns)
        `NO_LOCUS`, `DIRECTED` or `CHAOS`.
    angle : ndarray, shape (rows, columns)
        Radians in [0, π); 0 where the cell is not directed.
    magnitude : ndarray of int, shape (rows, columns)
        Walks in the highest bin; 0 where the cell is not directed.
    histograms : ndarray of int, shape (rows, columns, 8)
    """

    kind: np.ndarray
    angle: np.ndarray
    magnitude: np.ndarray
    histograms: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.kind.shape

    @property
    def directed(self) -> np.ndarray:
        """Which cells have a direction."""
        return self.kind == DIRECTED


def infer_angle(patterns: ArrayLike) -> PatternAngle:
    """The angle that patterns of 8×8 pixels show (Figure 2.4).

    It is the pixels' principal axis, that is, the line of total least squares.

    Parameters
    ----------
    patterns : array_like of bool, shape (..., 8, 8)
        Row 0 is the lowest.

    Returns
    -------
    PatternAngle
        Arrays of shape (...).  Patterns of fewer than five pixels, and those that are
        nearly as wide as long, show no direction.

    Raises
    ------
    ArgumentError
        When the shape or the type is another.
    """
    patterns = require_array("patterns", patterns, (..., MAP_PIXELS, MAP_PIXELS), dtype=bool)
    y, x = np.mgrid[:MAP_PIXELS, :MAP_PIXELS]
    parts = (np.ones_like(x), x, y, x * x, y * y, x * y)
    return _principal_axis(*((patterns * part).sum(axis=(-1, -2)) for part in parts))


def example_patterns() -> dict[str, np.ndarray]:
    """Patterns for Figure 2.4: strokes at the eight bins' centres, and some without an angle.

    Returns
    -------
    dict
        Name → pattern, ndarray of bool, shape (8, 8), row 0 the lowest.
    """
    y, x = np.mgrid[:MAP_PIXELS, :MAP_PIXELS] - (MAP_PIXELS - 1) / 2
    patterns = {}
    for k in range(BINS):
        cosine, sine = np.cos(k * np.pi / BINS), np.sin(k * np.pi / BINS)
        # Distance from the line along the axis it is steeper to; one pixel a step.
        offset = np.round((y * cosine - x * sine) / max(abs(cosine), abs(sine)), 9)
        patterns[f"{k}π/8"] = (offset > -0.5) & (offset <= 0.5)
    patterns["one pixel"] = np.hypot(x - 0.5, y - 0.5) < 0.5
    patterns["block"] = np.ones((MAP_PIXELS, MAP_PIXELS), bool)
    patterns["cross"] = patterns["0π/8"] | patterns["4π/8"]
    return patterns


def _principal_axis(n, x, y, xx, yy, xy):
    """Axis of pixels from their count and sums; whole numbers, so nothing is rounded."""
    spread_x, spread_y, both = n * xx - x * x, n * yy - y * y, n * xy - x * y
    angle = 0.5 * np.arctan2(2 * both, spread_x - spread_y)
    longer = np.hypot(spread_x - spread_y, 2 * both)
    known = (n >= LEAST_PIXELS) & (longer >= LEAST_ELONGATION * (spread_x + spread_y))
    return PatternAngle(np.where(known, _half_turn(angle), 0.0), known)


def _half_turn(angle):
    """Angles brought to [0, π)."""
    angle = np.mod(angle, np.pi)
    return np.where(angle >= np.pi, 0.0, angle)  # of −1e-17, mod makes π itself


def orientations(traces: pd.DataFrame, grid: GridMap, *, bridge: float = BRIDGE) -> pd.DataFrame:
    """Each trace's angle in each cell that it crosses (section 2.2.2).

    A trace marks the map pixels under its sightings and under the straight lines between
    them, 8×8 pixels a cell; the angle is the marked pixels' principal axis.  One walker has
    one vote a cell: a trace that leaves a cell and comes back still makes one pattern.  What
    lies outside the map is cut off.

    Parameters
    ----------
    traces : pandas.DataFrame
        A trace table, metres.
    grid : GridMap
    bridge : float, optional
        Metres; sightings farther apart are not joined.

    Returns
    -------
    pandas.DataFrame
        trace, row, column, angle; no row where a trace shows no direction in a cell:
        too few pixels, or nearly as wide as long, as of someone who lingers.

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound, no trace touches the map, or none shows a direction.
    """
    check_traces(traces)
    check_grid(grid)
    bridge = require_number("bridge", bridge, low=0, unit="metres")
    names = traces[TRACE].to_numpy(dtype=object)
    starts = starts_of(names)
    code = np.repeat(np.arange(len(starts)), np.diff(np.r_[starts, len(names)]))
    names = names[starts]
    # In units of map pixels, from the map's corner.
    places = (traces[[X, Y]].to_numpy(float) - [grid.left, grid.bottom]) / grid.pixel
    size = np.array([grid.columns, grid.rows]) * MAP_PIXELS
    between, at = _join(places, code[1:] == code[:-1], size, bridge / grid.pixel)
    places, code = np.concatenate([places, between]), np.r_[code, code[at]]
    on_map = ((places >= 0) & (places < size)).all(axis=1)
    if not on_map.any():
        raise ArgumentError(
            f"traces: none of the {code.max() + 1} touches the map, which covers "
            f"{' '.join(f'{side:g}' for side in grid.area)} m; lay the map over the traces."
        )
    column, row = places[on_map].astype(np.int64).T
    cell = (code[on_map] * grid.rows + row // MAP_PIXELS) * grid.columns + column // MAP_PIXELS
    pixel = row % MAP_PIXELS * MAP_PIXELS + column % MAP_PIXELS
    marked = np.sort(cell * MAP_PIXELS**2 + pixel)  # np.unique hashes, which takes longer
    cell, pixel = np.divmod(marked[starts_of(marked)], MAP_PIXELS**2)
    y, x = np.divmod(pixel, MAP_PIXELS)
    starts = starts_of(cell)
    parts = (np.ones_like(x), x, y, x * x, y * y, x * y)
    angle, known = _principal_axis(*(np.add.reduceat(part, starts) for part in parts))
    if not known.any():
        raise ArgumentError(
            "traces: none shows a direction in any cell; pass a grid with larger cells, a longer "
            "bridge between sightings, or traces of people who walk."
        )
    cell, angle = cell[starts][known], angle[known]
    code, cell = np.divmod(cell, grid.rows * grid.columns)
    row, column = np.divmod(cell, grid.columns)
    return pd.DataFrame({TRACE: names[code], ROW: row, COLUMN: column, ANGLE: angle})


def _join(places, same, size, bridge):
    """Points at most a pixel apart between sightings, and the row each one follows."""
    start, stop = places[:-1], places[1:]
    low, high = np.minimum(start, stop), np.maximum(start, stop)
    joined = same & (np.hypot(*(stop - start).T) <= bridge)
    joined &= ((high >= 0) & (low < size)).all(axis=1)
    steps = np.where(joined, np.ceil((high - low).max(axis=1)), 1).astype(np.int64)
    steps = np.maximum(steps, 1)
    if steps.sum() > MOST_SAMPLES:
        raise ArgumentError(
            "grid has cells too small for traces this long; pass larger cells, or check that "
            "the traces are in metres."
        )
    # Always from the lesser end, so that a walk back marks the very pixels of the walk there.
    swap = (start[:, 0] > stop[:, 0]) | ((start[:, 0] == stop[:, 0]) & (start[:, 1] > stop[:, 1]))
    first, last = np.where(swap[:, None], (stop, start), (start, stop))
    at = np.repeat(np.arange(len(steps)), steps - 1)
    number = np.arange(len(at)) - np.repeat(np.cumsum(steps - 1) - (steps - 1), steps - 1) + 1
    share = (number / steps[at])[:, None]
    return first[at] + share * (last - first)[at], at


def histograms(angles: pd.DataFrame, grid: GridMap) -> np.ndarray:
    """How many traces cross each cell in each direction (section 2.2.2, Figure 2.10).

    Bin k is centred on kπ/8.  Were it to begin there, walks straight along a corridor would
    fall on the edge of two bins.  The bins are circular: 7 and 0 are neighbours.

    Parameters
    ----------
    angles : pandas.DataFrame
        As from `orientations`.
    grid : GridMap

    Returns
    -------
    ndarray of int, shape (rows, columns, 8)

    Raises
    ------
    TableError, ArgumentError
        When a column is missing, a cell lies outside the grid, or an angle outside [0, π).
    """
    cell, angle = _check_angles(angles, check_grid(grid).shape)
    counts = np.bincount(cell * BINS + _bin(angle), minlength=grid.rows * grid.columns * BINS)
    return counts.reshape(*grid.shape, BINS)


def _bin(angle):
    return np.floor(angle * (BINS / np.pi) + 0.5).astype(np.int64) % BINS


def _check_angles(angles, shape, *, argument="angles"):
    """The flat index of each row's cell, and its angle."""
    check_columns(angles, ANGLE_COLUMNS, argument=argument)
    remedy = f"whole numbers of cells on the grid of {shape[0]}×{shape[1]}, as from orientations"
    row, column = (
        require_array(
            f"{argument}: {name}", angles[name], dtype=int, low=0, high=most - 1, remedy=remedy
        )
        for name, most in zip((ROW, COLUMN), shape, strict=True)
    )
    most = np.nextafter(np.pi, 0)
    remedy = "radians in [0, π), as from orientations"
    angle = require_array(f"{argument}: angle", angles[ANGLE], low=0, high=most, remedy=remedy)
    return row * shape[1] + column, angle


def direct_cells(
    histograms: ArrayLike,
    *,
    chaos_ratio: float = CHAOS_RATIO,
    least_traces: int = 1,
    refine: pd.DataFrame | None = None,
) -> DirectedCells:
    """Tell directed cells, chaos and cells without a locus apart (sections 2.2.2 and 2.3).

    A cell is chaos when any bin but the highest and its two neighbours reaches `chaos_ratio`
    of the highest, or when the highest holds fewer than `least_traces`.  Of equally high
    neighbouring bins the one with more walks beside it is taken, then the one on an axis or
    a diagonal, which a mirrored or turned scene chooses alike.  Equally high bins farther
    apart are chaos anyway.

    Parameters
    ----------
    histograms : array_like of int, shape (rows, columns, 8)
    chaos_ratio : float, optional
        Above 0, at most 1.
    least_traces : int, optional
        Walks in a bin that make a prominent maximum.
    refine : pandas.DataFrame, optional
        The angles that the histograms count.  With them, a cell's angle is the circular
        mean of those in the highest bin and its neighbours; without, the bin's centre,
        as in the thesis.

    Returns
    -------
    DirectedCells

    Raises
    ------
    TableError, ArgumentError
        When the histograms are not counts of that shape, a number is out of range, or
        the angles do not belong to the histograms.
    """
    remedy = f"counts up to 1e9 of shape (rows, columns, {BINS})"
    shape = (None, None, BINS)
    counts = require_array(
        "histograms", histograms, shape, dtype=int, low=0, high=10**9, remedy=remedy
    )
    if counts.size == 0:
        raise ArgumentError(f"histograms has the shape {counts.shape}, an empty map; pass cells.")
    chaos_ratio = require_number("chaos_ratio", chaos_ratio, above=0, high=1)
    least_traces = require_count("least_traces", least_traces, low=1)
    beside = np.roll(counts, 1, axis=-1) + np.roll(counts, -1, axis=-1)
    rank = counts * (2 * int(counts.max()) + 1) + beside
    top = np.argmax(2 * rank + (np.arange(BINS) % 2 == 0), axis=-1)
    highest = np.take_along_axis(counts, top[..., None], axis=-1)[..., 0]
    apart = np.abs(_turn(np.arange(BINS) - top[..., None])) > 1
    rival = np.where(apart, counts, 0).max(axis=-1)
    # 1e-9: 0.7 of 10 is not to be more than 7 by a rounding.
    chaos = (rival >= chaos_ratio * highest - 1e-9) | (highest < least_traces)
    kind = np.where(highest == 0, NO_LOCUS, np.where(chaos, CHAOS, DIRECTED))
    angle = top * (np.pi / BINS)
    if refine is not None:
        cell, each = _check_angles(refine, kind.shape, argument="refine")
        if not np.array_equal(
            np.bincount(cell * BINS + _bin(each), minlength=counts.size), counts.ravel()
        ):
            raise ArgumentError("refine holds other angles than histograms counts; pass the same.")
        near = np.abs(_turn(_bin(each) - top.ravel()[cell])) <= 1
        # The resultant cannot vanish: doubled, three bins span 3/4 of a half-turn.
        sine, cosine = (
            np.bincount(cell[near], part(2 * each[near]), minlength=kind.size).reshape(kind.shape)
            for part in (np.sin, np.cos)
        )
        angle = _half_turn(0.5 * np.arctan2(sine, cosine))
    directed = kind == DIRECTED
    return DirectedCells(kind, np.where(directed, angle, 0), np.where(directed, highest, 0), counts)


def _turn(bins):
    """The shorter way round between bins, −4 … 3."""
    return (bins + BINS // 2) % BINS - BINS // 2


def grow_band(cells: DirectedCells, *, keep: float = KEEP) -> np.ndarray:
    """Grow the path band from the strongest cell (section 2.2.3, Figure 2.6(a)).

    Neighbours, eight a cell, join step by step; those weaker than a share of the strongest
    are dropped.  Of several strongest the thesis takes any; here all start, so that the band
    does not depend on a draw.

    Parameters
    ----------
    cells : DirectedCells
    keep : float, optional
        Share of the strongest cell's magnitude that a cell needs, 0 to 1.

    Returns
    -------
    ndarray of int, shape (rows, columns)
        The step at which each cell joined, 0 the strongest; −1 outside the band.

    Raises
    ------
    ArgumentError
        When no cell is directed, or `keep` is out of range.
    """
    keep = require_number("keep", keep, low=0, high=1)
    require_directed(cells)
    strongest = cells.magnitude.max()
    wide = cells.shape[1] + 2
    waiting = np.pad(cells.directed & (cells.magnitude >= keep * strongest - 1e-9), 1).ravel()
    joined = np.full(waiting.shape, -1)
    beside = np.array([-wide - 1, -wide, -wide + 1, -1, 1, wide - 1, wide, wide + 1])
    front = np.flatnonzero(np.pad(cells.magnitude == strongest, 1).ravel())
    step = 0
    while len(front):
        joined[front], waiting[front] = step, False
        front = (front[:, None] + beside).ravel()
        front = np.unique(front[waiting[front]])
        step += 1
    return joined.reshape(-1, wide)[1:-1, 1:-1]


def path_band(cells: DirectedCells, *, keep: float = KEEP) -> np.ndarray:
    """The cells of the path band: those that `grow_band` reaches, shape (rows, columns)."""
    return grow_band(cells, keep=keep) >= 0


def thin(band: ArrayLike) -> np.ndarray:
    """The path band thinned to a line (section 2.2.3).

    Parameters
    ----------
    band : array_like of bool, shape (rows, columns)

    Returns
    -------
    ndarray of bool, shape (rows, columns)

    Raises
    ------
    ArgumentError
        When the band is empty or not a map of booleans.
    """
    from skimage.morphology import thin as thin_mask

    band = require_array("band", band, (None, None), dtype=bool)
    if not band.any():
        raise ArgumentError("band holds no cell; lower keep, or take in more traces.")
    return thin_mask(band)


def require_directed(cells: DirectedCells) -> None:
    """Raise unless a cell is directed; say what there is instead."""
    require_kind("cells", cells, DirectedCells, "what direct_cells gives")
    if cells.directed.any():
        return
    chaos = np.count_nonzero(cells.kind == CHAOS)
    if chaos:
        raise ArgumentError(
            f"cells: none is directed, {chaos} are chaos; raise chaos_ratio, lower least_traces, "
            "or pass a grid with smaller cells."
        )
    raise ArgumentError("cells: nobody crosses any; pass traces that cross the map.")
