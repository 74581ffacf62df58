"""The thesis's six cases of occlusion, each by a composite that fits its caption.

Thesis section 3.5, Figures 3.14 and 3.15.

CASIA A has nobody who crosses the view at level v1: at its walkers' distance that is four
centimetres a second.  A made street (`datasets.composites.make_street`) has some.
"""

from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from mcnlab.bundled import casia_a_folder
from mcnlab.datasets import casia
from mcnlab.datasets.composites import STREET_NAME, make_street
from mcnlab.datasets.mirror import SUFFIX, mirror_masks
from mcnlab.errors import ArgumentError, SilhouetteError
from mcnlab.silhouettes import find_body


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
        composites.known
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
