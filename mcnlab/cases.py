"""The thesis's six cases and every other composite: does the table say what happens?

Thesis sections 3.4 and 3.5, Figures 3.14 and 3.15.  Two walks laid over each other
(`datasets.composites`) are two people who never met: their boxes say when one covers the
other, and the first second that shows both is all that the tables and equations may see.

CASIA A has nobody who crosses the view at level v1: at its walkers' distance that is four
centimetres a second.  A made street (`datasets.composites.make_street`) has some.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from mcnlab import occlusion
from mcnlab.bundled import casia_a_folder
from mcnlab.columns import CX, CY, DIRECTION, FRAME, SEQUENCE, H, W, X, Y
from mcnlab.datasets import casia
from mcnlab.datasets.composites import STREET_NAME, check_shift, make_street
from mcnlab.datasets.mirror import SUFFIX, mirror_masks
from mcnlab.datasets.recording import Recording
from mcnlab.direction import DIRECTIONS, PRESENT
from mcnlab.errors import ArgumentError, SilhouetteError, require_number
from mcnlab.pairs import RULES
from mcnlab.perspective import estimate_cameras, measure_headings
from mcnlab.results import Estimate
from mcnlab.silhouettes import find_body
from mcnlab.speed import frames_of, level_of

SHIFTS: Final = (0.0, 0.5, 1.0, 1.5, 2.0)  # seconds from one walk's beginning to the other's
LEAST_FRAMES: Final = 4  # fewer show no heading
_CHUNK: Final = 4000  # pairs at a time: a few hundred numbers each


class Case(NamedTuple):
    """One of the thesis's test cases, as its caption says it."""

    figure: str
    directions: tuple  # D(S1), D(S2)
    levels: tuple | None  # V(S1), V(S2); None where the caption names none
    occludes: bool


# The text of section 3.5 swaps 3.15(c) and (d); the captions are right (misprint 3).
CASES: Final = (
    Case("3.14(a)", (3, 7), (3, 3), True),
    Case("3.14(b)", (3, 6), (3, 3), True),
    Case("3.15(a)", (2, 6), None, True),
    Case("3.15(b)", (3, 7), None, True),
    Case("3.15(c)", (3, 3), (3, 1), True),
    Case("3.15(d)", (3, 3), (1, 1), False),
)


@dataclass(frozen=True)
class Composites:
    """Pairs of walks of one recording, each at one moment.

    Attributes
    ----------
    recording : Recording
        That the walks are from.
    table : pandas.DataFrame
        One row a composite; ``first, second`` and ``shift`` are what `composites.compose`
        takes.

        - ``frame``: the moment of decision, the last frame of the first second that shows
          both, in the composite's clock;
        - ``swapped``: whether S1, the walker on the left, is ``second``;
        - ``x1, y1, x2, y2``: the centroids of S1 and S2 at that moment, pixels;
        - ``direction1, direction2, level1, level2``: measured in that second;
        - ``p1, p2``: pixels travelled in it;
        - ``rule``: what the tables say, `occlusion.CERTAIN`, `BY_SPEED`, `APART` or
          `UNIDENTIFIED`;
        - ``said, said_seconds, said_x, said_y``: `occlusion.foresee`; seconds are inf for
          never;
        - ``occludes, seconds, x, y``: the truth, from the boxes: the first later frame in
          which both are boxed and the intersection is more than ``RULES.cover`` of the
          smaller box; where there is none, seconds are inf and the place is the middle
          between the two now;
        - ``left``: seconds of video after the moment in which both are still walking.
    """

    recording: Recording
    table: pd.DataFrame

    def people(self, column):
        """Who walks, one name a row: `column` is ``"first"`` or ``"second"``."""
        return self.table[column].astype(str).map(self.recording.subjects).to_numpy(str)


def compose_all(recording, *, focal_length, shifts=SHIFTS, seconds=1.0):
    """Every two walks of different people over each other, at several offsets.

    Directions come from perspective (`perspective.measure_headings`), levels and the way of
    motion from where the centroid was at the second's two ends.  A camera that does not move
    knows its horizon: that is taken from all of a subject's walks.

    Parameters
    ----------
    recording : Recording
    focal_length : float
        Pixels.
    shifts : sequence of float, optional
        Seconds by which the second walk begins later; at least 0, since every two walks
        are taken in both orders.
    seconds : float, optional
        How long both are watched before the decision.

    Returns
    -------
    Composites
        Without pairs that cover each other already by more than ``RULES.apart``, and without
        walkers whose second has too few boxes or who stand still in it.  Walks of one
        person are laid over each other only where the recording has no other.

    Raises
    ------
    McnError
        When the table is not sound, a number is out of range, or nothing can be composed.
    """
    focal_length = require_number("focal_length", focal_length, above=0, unit="pixels")
    window = frames_of(seconds, recording.frame_rate)
    if window < LEAST_FRAMES:
        raise ArgumentError(
            f"seconds is {seconds:g}, {window} frames at {recording.frame_rate:g} a second; a "
            f"direction needs {LEAST_FRAMES}: pass at least "
            f"{LEAST_FRAMES / recording.frame_rate:g}."
        )
    offsets = [
        check_shift(
            round(require_number("shifts", shift, low=0, unit="seconds") * recording.frame_rate)
        )
        for shift in shifts
    ]
    if not offsets:
        raise ArgumentError("shifts is empty; pass at least one offset in seconds, such as 0.")
    cameras = estimate_cameras(recording, focal_length=focal_length)
    begun = _watch(recording, 0, window, focal_length, cameras)
    parts = []
    for offset in dict.fromkeys(offsets):
        later = begun if offset == 0 else _watch(recording, offset, window, focal_length, cameras)
        first, second = np.nonzero(_may_meet(recording, offset) & later.usable[:, None])
        keep = begun.usable[second]
        first, second = first[keep], second[keep]
        for at in range(0, len(first), _CHUNK):
            chunk = slice(at, at + _CHUNK)
            parts.append(
                _decide(recording, later, begun, first[chunk], second[chunk], offset, window)
            )
    table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()
    if table.empty:
        raise ArgumentError(
            f"recording {recording.name} has no two walks that can be watched together for "
            f"{seconds:g} s before they cover each other; pass more or longer walks."
        )
    return Composites(recording, table)


class _Watched(NamedTuple):
    """What one second of each walk shows, one element a walk."""

    usable: np.ndarray
    walker: occlusion.Walker
    level: np.ndarray


def _watch(recording, offset, window, focal_length, cameras):
    """Direction, speed and place of every walk in the `window` frames from `offset` on."""
    stack = recording.stack
    count, longest = stack.valid.shape
    usable = np.zeros(count, bool)
    empty = np.zeros(count)
    nothing = occlusion.Walker(empty, empty, empty.astype(int), empty, empty, empty)
    last = offset + window - 1
    if last >= longest:
        return _Watched(usable, nothing, empty.astype(int))
    ends = stack.valid[:, offset] & stack.valid[:, last]
    boxed = stack.valid[:, offset : last + 1].sum(axis=1)
    usable = ends & (boxed >= max(PRESENT * window, LEAST_FRAMES))
    if not usable.any():
        return _Watched(usable, nothing, empty.astype(int))
    direction = _directions(recording, offset, window, usable, focal_length, cameras)
    usable &= direction > 0
    # One second has one interval fewer than frames.
    rate = recording.frame_rate / (window - 1)
    vx, vy = (
        rate * (stack.curves[name][:, last] - stack.curves[name][:, offset]) for name in (CX, CY)
    )
    pixels = np.hypot(vx, vy)
    level = level_of(np.where(usable, pixels, 0.0), frame_width=recording.frame_width)
    x, y = stack.curves[CX][:, last], stack.curves[CY][:, last]
    return _Watched(usable, occlusion.Walker(x, y, direction, pixels, vx, vy), level)


def _directions(recording, offset, window, usable, focal_length, cameras):
    """Each usable walk's direction in a window, 1 … 8; 0 where there is none."""
    stack, boxes = recording.stack, recording.boxes
    row = boxes[SEQUENCE].map({name: place for place, name in enumerate(stack.names)}).to_numpy()
    since = boxes[FRAME].to_numpy() - stack.start[row]
    inside = (since >= offset) & (since < offset + window) & usable[row]
    part = recording.with_boxes(
        boxes[inside].reset_index(drop=True), directions=None, copies=frozenset()
    )
    try:
        headings = measure_headings(part, focal_length=focal_length, cameras=cameras)
    except ArgumentError:
        return np.zeros(len(stack.names), int)  # the frame's edge cuts all of them
    direction = pd.Series(headings[DIRECTION].to_numpy(), index=headings[SEQUENCE])
    return direction.reindex(stack.names, fill_value=0).to_numpy(int)


def _may_meet(recording, offset):
    """Which two walks make a composite, shape (n, n): the first one began `offset` earlier."""
    person = pd.factorize(recording.subjects[recording.stack.names])[0]
    # Alone in a recording, one meets oneself; a walk never meets itself.
    alone = person.max() == 0
    apart = ~np.eye(len(person), dtype=bool) if alone else person[:, None] != person
    return np.triu(apart) if offset == 0 else apart


def _decide(recording, later, begun, first, second, offset, window):
    """Forecast and truth of some pairs, as a table."""
    stack = recording.stack
    one = occlusion.Walker(*(values[first] for values in later.walker))
    two = occlusion.Walker(*(values[second] for values in begun.walker))
    now, truth = _cover_ahead(stack, first, second, offset, window)
    clear = now <= RULES.apart
    first, second = first[clear], second[clear]
    one, two = (occlusion.Walker(*(values[clear] for values in who)) for who in (one, two))
    cover, valid, x, y = (values[clear] for values in truth)
    hit = cover > RULES.cover
    occludes = hit.any(axis=1)
    when = hit.argmax(axis=1)
    rows = np.arange(len(first))
    swapped = two.x < one.x
    said = occlusion.foresee(
        one, two, frame_width=recording.frame_width, frame_height=recording.frame_height
    )
    levels = later.level[first], begun.level[second]
    left, right = (
        occlusion.Walker(*(np.where(swapped, b, a) for a, b in zip(*who, strict=True)))
        for who in ((one, two), (two, one))
    )
    middle = (one.x + two.x) / 2, (one.y + two.y) / 2
    names = np.array(stack.names, dtype=object)
    last = np.where(valid.any(axis=1), valid.shape[1] - valid[:, ::-1].argmax(axis=1), 0)
    return pd.DataFrame(
        {
            "first": names[first],
            "second": names[second],
            "shift": offset,
            "frame": offset + window,
            "swapped": swapped,
            "x1": left.x,
            "y1": left.y,
            "x2": right.x,
            "y2": right.y,
            "direction1": left.direction,
            "direction2": right.direction,
            "level1": np.where(swapped, levels[1], levels[0]),
            "level2": np.where(swapped, levels[0], levels[1]),
            "p1": left.pixels,
            "p2": right.pixels,
            "rule": said.rule,
            "said": said.occludes,
            "said_seconds": said.seconds,
            "said_x": said.x,
            "said_y": said.y,
            "occludes": occludes,
            "seconds": np.where(occludes, (when + 1) / recording.frame_rate, np.inf),
            "x": np.where(occludes, x[rows, when], middle[0]) if valid.size else middle[0],
            "y": np.where(occludes, y[rows, when], middle[1]) if valid.size else middle[1],
            "left": last / recording.frame_rate,
        }
    )


def _cover_ahead(stack, first, second, offset, window):
    """Cover at the decision; cover, presence and middle of the intersection after it."""
    begin = offset + window - 1, window - 1
    length = stack.valid.shape[1] - max(begin)
    cut = [slice(at, at + length) for at in begin]
    valid = stack.valid[:, cut[0]][first] & stack.valid[:, cut[1]][second]
    one, two = (
        {name: stack.curves[name][:, at][walk] for name in (X, Y, W, H)}
        for walk, at in zip((first, second), cut, strict=True)
    )
    low = [np.maximum(one[name], two[name]) for name in (X, Y)]
    high = [
        np.minimum(one[name] + one[size], two[name] + two[size]) for name, size in ((X, W), (Y, H))
    ]
    across, down = (np.maximum(stop - start, 0) for start, stop in zip(low, high, strict=True))
    smaller = np.minimum(one[W] * one[H], two[W] * two[H])
    cover = np.where(valid, across * down / np.where(valid, smaller, 1.0), 0.0)
    # A box covers pixels x … x + w − 1, so its middle is half a pixel before x + w/2.
    x, y = ((start + stop - 1) / 2 for start, stop in zip(low, high, strict=True))
    return cover[:, 0], (cover[:, 1:], valid[:, 1:], x[:, 1:], y[:, 1:])


def find_fitting(composites, case):
    """Which composites fit a case's caption.

    Parameters
    ----------
    composites : Composites
    case : Case

    Returns
    -------
    ndarray of bool
        True where directions and levels, as measured, are the caption's, S1 being on the
        left, and both walks begin together.
    """
    table = composites.table
    fits = (
        _known(composites)
        & (table["shift"] == 0)
        & (table["direction1"] == case.directions[0])
        & (table["direction2"] == case.directions[1])
    )
    if case.levels is not None:
        fits &= (table["level1"] == case.levels[0]) & (table["level2"] == case.levels[1])
    return fits.to_numpy()


def choose_case(composites, case, *, taken=()):
    """The composite that stands for a case: of all that fit its caption, one.

    Of those that fit, the two walkers farthest apart at the decision are taken (the first
    in table order where several are): they call for the longest foresight.  What happens
    to them later has no say.

    Parameters
    ----------
    composites : Composites
    case : Case
    taken : iterable of pairs of str, optional
        Composites, ``(first, second)``, that stand for other cases already.

    Returns
    -------
    pandas.Series or None
        A row of the table; None where nothing fits.
    """
    table = composites.table[find_fitting(composites, case)]
    free = [pair not in set(taken) for pair in zip(table["first"], table["second"], strict=True)]
    table = table[np.array(free, dtype=bool)]
    if table.empty:
        return None
    return table.loc[np.hypot(table["x2"] - table["x1"], table["y2"] - table["y1"]).idxmax()]


def judge_cases(sources, *, cases=CASES):
    """The six cases: what was foreseen, what happened, and whether both agree.

    Parameters
    ----------
    sources : sequence of Composites
        Where to look, in turn: a case is taken from the first that has it.
    cases : sequence of Case, optional

    Returns
    -------
    pandas.DataFrame
        One row a case that some source has: ``figure``, ``source`` (its place in
        `sources`), ``data`` (its name), ``caption`` (occlusion or not), ``right`` (the boxes
        do what was foreseen, and both are what the caption says), ``fitting`` and
        ``fitting_right`` (how many composites of that source fit the caption, and in how
        many the boxes do what was foreseen), and the composite's own columns.

    Raises
    ------
    ArgumentError
        When no composite fits any case.
    """
    rows, taken = [], []
    for case in cases:
        for number, source in enumerate(sources):
            chosen = choose_case(source, case, taken=taken)
            if chosen is None:
                continue
            taken.append((chosen["first"], chosen["second"]))
            fitting = source.table[find_fitting(source, case)]
            head = {
                "figure": case.figure,
                "source": number,
                "data": source.recording.name,
                "caption": case.occludes,
                "right": bool(chosen["said"] == chosen["occludes"] == case.occludes),
                "fitting": len(fitting),
                "fitting_right": int((fitting["said"] == fitting["occludes"]).sum()),
            }
            rows.append({**head, **chosen})
            break
    if not rows:
        raise ArgumentError("sources: no composite fits any case; pass recordings with more walks.")
    return pd.DataFrame(rows)


def silhouettes_of(recording, sequence, frames):
    """The silhouettes of a walk in some of its frames, where there are any.

    Parameters
    ----------
    recording : Recording
        CASIA A, whose images lie under ``MCNLAB_DATA`` or nowhere, or the made street as
        `composites.make_street` makes it unless told otherwise.
    sequence : str
    frames : sequence of int
        Frame numbers of the recording's own clock.

    Returns
    -------
    ndarray of uint8, shape (len(frames), height, width), or None
        0 or 255, specks taken away; None where no images are at hand.
    """
    frames = np.asarray(frames, dtype=int)
    if recording.name == STREET_NAME:
        street = make_street()
        own = recording.boxes is street.recording.boxes
        return street.masks(sequence)[frames - 1] if own else None
    folder = casia_a_folder() if recording.name == casia.NAME else None
    if folder is None:
        return None
    wanted = sequence.removesuffix(SUFFIX)
    found = {held.name: held for held in casia.find_sequences(folder)}
    if wanted not in found:
        return None
    masks = np.stack([_body(casia.read_silhouette(found[wanted].paths[at - 1])) for at in frames])
    return mirror_masks(masks) if sequence.endswith(SUFFIX) else masks


def _body(mask):
    try:
        return find_body(mask).mask
    except SilhouetteError:
        return mask


def count_cells(composites):
    """What happened in each of the 64 cells of Table 3.1.

    Parameters
    ----------
    composites : Composites

    Returns
    -------
    pandas.DataFrame
        One row a cell, D(S1) by D(S2): ``direction1, direction2``, ``printed`` (the code in
        Table 3.1), ``n`` composites, ``occluded`` of them, ``right`` (how often the two
        tables and the equations were).
    """
    table = _told_apart(composites)
    place = 8 * (table["direction1"].to_numpy() - 1) + table["direction2"].to_numpy() - 1
    right = (table["said"] == table["occludes"]).to_numpy()
    cells = pd.MultiIndex.from_product([DIRECTIONS] * 2, names=["direction1", "direction2"])
    return pd.DataFrame(
        {
            "printed": occlusion.direction_table().ravel(),
            "n": np.bincount(place, minlength=64),
            "occluded": np.bincount(place, table["occludes"], minlength=64).astype(int),
            "right": np.bincount(place, right, minlength=64).astype(int),
        },
        index=cells,
    ).reset_index()


def count_rules(composites):
    """How each rule of the tables fares.

    Returns
    -------
    pandas.DataFrame
        One row a rule, certain, by speed (a C) and apart (a 0): ``n`` composites, ``said``
        yes, ``occluded``, ``hits`` (said and occluded), ``precision`` of its yes and
        ``share`` of all occlusions that fell to it; a share of nothing is left empty.
    """
    table = _told_apart(composites)
    rows = {}
    for name, code in (
        ("certain", occlusion.CERTAIN),
        ("by speed", occlusion.BY_SPEED),
        ("apart", occlusion.APART),
    ):
        own = table[table["rule"] == code]
        said, occluded = int(own["said"].sum()), int(own["occludes"].sum())
        hits = int((own["said"] & own["occludes"]).sum())
        every = int(table["occludes"].sum())
        rows[name] = {
            "n": len(own),
            "said": said,
            "occluded": occluded,
            "hits": hits,
            "precision": hits / said if said else None,
            "recall": hits / occluded if occluded else None,
            "share": occluded / every if every else None,
        }
    return pd.DataFrame.from_dict(rows, orient="index")


def explain_errors(composites):
    """Why the tables and equations err.

    Returns
    -------
    dict of str to int
        How many composites are a ``false yes``; of these, ``video ends first`` (the foreseen
        time lies beyond it) and ``miss in time`` (it does not).  How many are a ``missed``
        occlusion; of these, ``levels alike`` and ``one ahead faster`` (0 in Tables 3.2 and
        3.3), ``departing`` (0 in Table 3.1) and ``out of frame`` (a C whose place lies
        outside).
    """
    table = _told_apart(composites)
    wrong = table[table["said"] & ~table["occludes"]]
    missed = table[~table["said"] & table["occludes"]]
    late = wrong["said_seconds"] > wrong["left"]
    printed = occlusion.direction_table()[missed["direction1"] - 1, missed["direction2"] - 1]
    by_level = (printed == occlusion.BY_SPEED) & (missed["rule"] == occlusion.APART)
    alike = missed["level1"] == missed["level2"]
    counts = {
        "false yes": len(wrong),
        "video ends first": late.sum(),
        "miss in time": (~late).sum(),
        "missed": len(missed),
        "levels alike": (by_level & alike).sum(),
        "one ahead faster": (by_level & ~alike).sum(),
        "departing": (printed == occlusion.APART).sum(),
        "out of frame": (missed["rule"] == occlusion.BY_SPEED).sum(),
    }
    return {name: int(count) for name, count in counts.items()}


def judge_table(composites, *, in_time=False, draws=1000, seed=0):
    """How often the tables and equations are right over all composites.

    Parameters
    ----------
    composites : Composites
    in_time : bool, optional
        Take a yes for a yes only where its time comes before the video ends; as printed, a
        certain occlusion is certain however far off.
    draws, seed : int, optional
        Of the bootstrap: people are drawn, and a composite counts as often as both of its
        people were.

    Returns
    -------
    dict of str to Estimate
        ``right``, ``precision``, ``recall``; None where nothing was said or happened.
        ``n`` counts people; fewer than three show no spread, and there is no interval.

    Raises
    ------
    ArgumentError
        When there is nothing to judge.
    """
    table = _told_apart(composites)
    if table.empty:
        raise ArgumentError("composites holds no composite in which S1 and S2 are told apart.")
    said = table["said"].to_numpy()
    if in_time:
        said = said & (table["said_seconds"] <= table["left"]).to_numpy()
    truth = table["occludes"].to_numpy()
    names, codes = np.unique(
        [composites.people("first"), composites.people("second")], return_inverse=True
    )
    codes, size = codes.reshape(2, -1)[:, _known(composites)], len(names)
    cells = codes[0] * size + codes[1]

    def meetings(flags):
        return np.bincount(cells, flags, minlength=size**2).reshape(size, size)

    parts = {
        "right": (said == truth, np.ones(len(truth), bool)),
        "precision": (said & truth, said),
        "recall": (said & truth, truth),
    }
    rng = np.random.default_rng(seed)
    drawn = rng.multinomial(size, np.full(size, 1 / size), size=draws).astype(float)
    found = {}
    for name, (hit, every) in parts.items():
        if not every.any():
            found[name] = None
            continue
        value = float(hit.sum() / every.sum())
        hits, alls = (
            np.einsum("di,ij,dj->d", drawn, meetings(part), drawn) for part in (hit, every)
        )
        shares = hits[alls > 0] / alls[alls > 0]
        spread = np.percentile(shares, [2.5, 97.5]).tolist() if size > 2 else (None, None)
        found[name] = Estimate(value, *spread, size)
    return found


def _known(composites):
    return (composites.table["rule"] != occlusion.UNIDENTIFIED).to_numpy()


def _told_apart(composites):
    """The composites in which S1 and S2 are told apart."""
    return composites.table[_known(composites)]
