"""From how people walk to where cameras should stand, as chapter 2 of the thesis does it.

Each trace's direction is read in each cell of the grid map from its pixels there; the cell's
histogram of directions makes it directed, chaos, or empty; each directed cell votes for all
cells on the perpendicular to its direction; the humps of the votes are the places from which
walkers are seen square-on (sections 2.2.2–2.2.4 and 2.3, Figures 2.3–2.6, 2.10 and 2.11).

The steps are separate functions, so that a changed threshold repeats only what follows it.
Angles are radians in [0, π), anticlockwise from x: walks there and back are one direction.

References
----------
R. Raman, "Study on Models for Smart Surveillance through Multi-Camera Networks", 2013.
L. Vincent, "Morphological grayscale reconstruction in image analysis", IEEE Trans. Image
Processing 2(2), 1993 (humps by their prominence).
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from mcnlab.columns import TRACE, X, Y, check_columns, check_traces, starts_of
from mcnlab.errors import ArgumentError, require_choice, require_count, require_number
from mcnlab.ground import MAP_PIXELS, check_grid

ROW: Final = "row"  # a cell's row on the grid map, 0 the lowest
COLUMN: Final = "column"  # a cell's column, 0 the leftmost
ANGLE: Final = "angle"  # a trace's direction in a cell, radians in [0, π)
VOTES: Final = "votes"  # perpendiculars that pass through a cell
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
SEPARATION = 2.0  # m; two humps nearer than this are one place for a camera
PROMINENCE = 0.2  # of the highest hump; how far a hump must stand out
FINE = 64  # orientations of the perpendiculars to refined directions


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
    def shape(self):
        """Rows and columns."""
        return self.kind.shape

    @property
    def directed(self):
        """Which cells have a direction."""
        return self.kind == DIRECTED


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
    band: np.ndarray
    votes: np.ndarray
    humps: pd.DataFrame
    places: pd.DataFrame


def infer_angle(patterns):
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
    patterns = _as_array("patterns", patterns)
    if patterns.dtype != bool or patterns.shape[-2:] != (MAP_PIXELS, MAP_PIXELS):
        raise ArgumentError(
            f"patterns has the shape {patterns.shape} of {patterns.dtype}; pass booleans, "
            f"shape (..., {MAP_PIXELS}, {MAP_PIXELS})."
        )
    y, x = np.mgrid[:MAP_PIXELS, :MAP_PIXELS]
    parts = (np.ones_like(x), x, y, x * x, y * y, x * y)
    return _principal_axis(*((patterns * part).sum(axis=(-1, -2)) for part in parts))


def example_patterns():
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


def orientations(traces, grid, *, bridge=BRIDGE):
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


def histograms(angles, grid):
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
    row, column, angle = (angles[name].to_numpy() for name in (ROW, COLUMN, ANGLE))
    if any(values.dtype.kind not in "iu" for values in (row, column)) and len(angles):
        raise ArgumentError(f"{argument} holds cells that are not whole numbers; see orientations.")
    if len(angles) and not (
        min(row.min(), column.min()) >= 0 and row.max() < shape[0] and column.max() < shape[1]
    ):
        raise ArgumentError(
            f"{argument} has cells outside the grid of {shape[0]}×{shape[1]} cells; pass the grid "
            "that the angles were taken on."
        )
    if angle.dtype.kind != "f" or not ((angle >= 0) & (angle < np.pi)).all():
        raise ArgumentError(f"{argument}: angles must lie in [0, π) radians; see orientations.")
    return row.astype(np.int64) * shape[1] + column, angle


def direct_cells(histograms, *, chaos_ratio=CHAOS_RATIO, least_traces=1, refine=None):
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
    counts = _check_histograms(histograms)
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


def _check_histograms(histograms):
    counts = _as_array("histograms", histograms)
    if counts.dtype.kind not in "iu" or counts.ndim != 3 or counts.shape[2] != BINS:
        raise ArgumentError(
            f"histograms has the shape {counts.shape} of {counts.dtype}; pass whole counts, "
            f"shape (rows, columns, {BINS})."
        )
    if counts.size == 0:
        raise ArgumentError(f"histograms has the shape {counts.shape}, an empty map; pass cells.")
    if counts.min() < 0 or counts.max() > 1_000_000_000:
        raise ArgumentError("histograms holds counts below 0 or above 1e9; count again.")
    return counts.astype(np.int64)


def grow_band(cells, *, keep=KEEP):
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
    _require_directed(cells)
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


def path_band(cells, *, keep=KEEP):
    """The cells of the path band: those that `grow_band` reaches, shape (rows, columns)."""
    return grow_band(cells, keep=keep) >= 0


def thin(band):
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

    band = _check_mask("band", band, None)
    if not band.any():
        raise ArgumentError("band holds no cell; lower keep, or take in more traces.")
    return thin_mask(band)


def vote(cells, *, weights="cells", band=None, orientations=BINS):
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
    require_choice("weights", weights, ("cells", "traces"))
    count = require_count("orientations", orientations, low=BINS)
    if count % BINS or count > 1024:
        raise ArgumentError(
            f"orientations is {count}; pass a multiple of {BINS}, at most 1024, so that each "
            "bin's centre is among them."
        )
    _require_directed(cells)
    voting = cells.directed
    if band is not None:
        voting = voting & _check_mask("band", band, cells.shape)
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
    votes, grid, *, separation=SEPARATION, prominence=PROMINENCE, smooth=0.0, forbidden=None
):
    """The humps of the votes, the best first (Figure 2.11).

    A hump stands out: to reach a higher one, one must first go down by more than `prominence`
    times the highest.  Digital lines cross in many small peaks that are none.  Of equally high
    cells on a hump the one nearest to their middle is taken; of humps nearer than `separation`
    only the higher remains.

    Parameters
    ----------
    votes : array_like, shape (rows, columns)
    grid : GridMap
    separation : float, optional
        Metres.
    prominence : float, optional
        Share of the highest, above 0, at most 1.
    smooth : float, optional
        Standard deviation of the Gaussian the votes are first smoothed by, metres; 0, as
        in the thesis, does not.
    forbidden : array_like of bool, shape (rows, columns), optional
        Where no camera can be.  These cells count as without votes.

    Returns
    -------
    pandas.DataFrame
        row, column, x, y (metres), votes (not smoothed).

    Raises
    ------
    ArgumentError
        When the votes are not a map of finite numbers on that grid, every cell with votes is
        forbidden, or a number is out of range.
    """
    from scipy import ndimage
    from skimage.morphology import local_maxima, reconstruction

    votes, allowed = _check_votes(votes, grid, forbidden)
    separation = require_number("separation", separation, low=0, unit="metres")
    prominence = require_number("prominence", prominence, above=0, high=1)
    smooth = require_number("smooth", smooth, low=0, unit="metres")
    surface = votes.astype(float)
    if smooth > 0:
        surface = ndimage.gaussian_filter(surface, smooth / grid.cell, mode="constant")
    # A rim below the ground lets a hump stand on the map's edge, or be the whole map.
    surface = np.pad(np.where(allowed, surface, 0.0), 1, constant_values=-1.0)
    eight = np.ones((3, 3))
    cut = reconstruction(surface - prominence * surface.max(), surface, footprint=eight)
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
        free &= np.hypot(row - row[best], column - column[best]) * grid.cell >= separation
        free[best] = False
    return _place_table(row[kept], column[kept], votes, grid)


def choose_places(
    votes,
    grid,
    n,
    *,
    separation=SEPARATION,
    prominence=PROMINENCE,
    smooth=0.0,
    forbidden=None,
    humps=None,
):
    """The best n places for cameras (section 2.3).

    The humps come first.  When they are fewer than n, the cells with most votes follow that
    are at least `separation` from every place chosen before.

    Parameters
    ----------
    votes, grid, separation, prominence, smooth, forbidden
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
        humps = find_humps(
            votes,
            grid,
            separation=separation,
            prominence=prominence,
            smooth=smooth,
            forbidden=forbidden,
        )
    votes, allowed = _check_votes(votes, grid, forbidden)
    separation = require_number("separation", separation, low=0, unit="metres")
    left = np.where(allowed, votes, 0)
    if n > np.count_nonzero(left):
        raise ArgumentError(
            f"n is {n}, but only {np.count_nonzero(left)} allowed cells have votes; pass a "
            "smaller n, or forbid less."
        )
    chosen = list(zip(humps[ROW], humps[COLUMN], strict=True))[:n]
    y, x = np.ogrid[: grid.rows, : grid.columns]
    for row, column in chosen:
        left[_within(x - column, y - row, separation / grid.cell)] = 0
    while len(chosen) < n and left.any():
        row, column = (int(at) for at in np.unravel_index(np.argmax(left), left.shape))
        chosen.append((row, column))
        left[_within(x - column, y - row, separation / grid.cell)] = 0
    if len(chosen) < n:
        raise ArgumentError(
            f"n is {n}, but only {len(chosen)} allowed places with votes exist at least "
            f"{separation:g} m apart; pass a smaller n or separation, or forbid less."
        )
    row, column = np.array(chosen).T
    return _place_table(row, column, votes, grid)


def _within(x, y, radius):
    """Cells nearer than a radius, and the cell itself."""
    square = x**2 + y**2
    return (square < radius**2) | (square == 0)


def place_by_votes(
    traces,
    grid,
    *,
    n=None,
    chaos_ratio=CHAOS_RATIO,
    least_traces=1,
    refine=False,
    weights="cells",
    use_band=False,
    keep=KEEP,
    separation=SEPARATION,
    prominence=PROMINENCE,
    smooth=0.0,
    forbidden=None,
    angles=None,
):
    """From traces to camera places, the whole of the thesis's chapter 2.

    Parameters
    ----------
    traces : pandas.DataFrame
        A trace table, metres; not looked at when `angles` is passed.
    grid : GridMap
    n : int, optional
        Cameras to place; without it, one on each hump.
    chaos_ratio, least_traces
        As in `direct_cells`.
    refine : bool, optional
        Take the mean direction of a cell's walks, not the bin's centre, and perpendiculars
        in 64 orientations, not 8: beyond the thesis.
    weights
        As in `vote`.
    use_band : bool, optional
        Let only the thinned path band vote, as the thesis advises when walks are many.
    keep
        As in `grow_band`.
    separation, prominence, smooth, forbidden
        As in `find_humps`.
    angles : pandas.DataFrame, optional
        What `orientations` gave for these traces on this grid, to save computing it again.

    Returns
    -------
    Placement

    Raises
    ------
    TableError, ArgumentError
        As in the steps.
    """
    check_grid(grid)
    if angles is None:
        angles = orientations(traces, grid)
    cells = direct_cells(
        histograms(angles, grid),
        chaos_ratio=chaos_ratio,
        least_traces=least_traces,
        refine=angles if refine else None,
    )
    band = thin(path_band(cells, keep=keep)) if use_band else None
    votes = vote(cells, weights=weights, band=band, orientations=FINE if refine else BINS)
    how = dict(
        separation=separation, prominence=prominence, smooth=smooth, forbidden=forbidden
    )  # shared by both steps
    humps = find_humps(votes, grid, **how)
    places = humps if n is None else choose_places(votes, grid, n, humps=humps, **how)
    return Placement(angles, cells, band, votes, humps, places)


def _require_directed(cells):
    """Raise unless a cell is directed; say what there is instead."""
    if not isinstance(cells, DirectedCells):
        raise ArgumentError(f"cells is a {type(cells).__name__}; pass what direct_cells gives.")
    if cells.directed.any():
        return
    chaos = np.count_nonzero(cells.kind == CHAOS)
    if chaos:
        raise ArgumentError(
            f"cells: none is directed, {chaos} are chaos; raise chaos_ratio, lower least_traces, "
            "or pass a grid with smaller cells."
        )
    raise ArgumentError("cells: nobody crosses any; pass traces that cross the map.")


def _as_array(name, values):
    try:
        return np.asarray(values)
    except ValueError as fault:
        raise ArgumentError(f"{name} has rows of different lengths; pass an array.") from fault


def _check_mask(name, mask, shape):
    mask = _as_array(name, mask)
    if mask.dtype != bool or mask.ndim != 2 or (shape is not None and mask.shape != shape):
        wanted = "(rows, columns)" if shape is None else str(shape)
        raise ArgumentError(
            f"{name} has the shape {mask.shape} of {mask.dtype}; pass booleans, shape {wanted}."
        )
    return mask


def _check_votes(votes, grid, forbidden):
    votes = _as_array("votes", votes)
    check_grid(grid)
    if votes.dtype.kind not in "iuf" or votes.shape != grid.shape:
        raise ArgumentError(
            f"votes has the shape {votes.shape} of {votes.dtype}; pass numbers, one a cell of "
            f"the grid, shape {grid.shape}."
        )
    if not np.isfinite(votes).all() or votes.min() < 0:
        raise ArgumentError("votes holds negative or not finite values; see vote.")
    allowed = np.ones(votes.shape, bool)
    if forbidden is not None:
        allowed = ~_check_mask("forbidden", forbidden, grid.shape)
    if not (votes[allowed] > 0).any():
        raise ArgumentError(
            f"forbidden and votes leave no place: of {votes.size} cells {allowed.sum()} are allowed"
            ", none of them with votes; forbid less, or take in more traces."
        )
    return votes, allowed


def _place_table(row, column, votes, grid):
    x, y = grid.place_of(row, column)
    return pd.DataFrame({ROW: row, COLUMN: column, X: x, Y: y, VOTES: votes[row, column]})
