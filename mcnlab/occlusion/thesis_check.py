"""The thesis's six cases of occlusion, each by a composite that fits its caption.

Thesis section 3.5, Figures 3.14 and 3.15.

CASIA A has nobody who crosses the view at level v1: at its walkers' distance that is four
centimetres a second.  A made street (`datasets.composites.make_street`) has some.
"""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from mcnlab.compass import DIRECTIONS
from mcnlab.errors import ArgumentError
from mcnlab.occlusion import thesis
from mcnlab.occlusion.composites import Composites
from mcnlab.statistics import Estimate, draw_pairs, share_by_pair


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


def find_fitting(composites: Composites, case: Case) -> np.ndarray:
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


def choose_case(
    composites: Composites, case: Case, *, taken: Iterable[tuple[str, str]] = ()
) -> pd.Series | None:
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


def judge_cases(sources: Sequence[Composites], *, cases: Sequence[Case] = CASES) -> pd.DataFrame:
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


def count_cells(composites: Composites) -> pd.DataFrame:
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
            "printed": thesis.direction_table().ravel(),
            "n": np.bincount(place, minlength=64),
            "occluded": np.bincount(place, table["occludes"], minlength=64).astype(int),
            "right": np.bincount(place, right, minlength=64).astype(int),
        },
        index=cells,
    ).reset_index()


def count_rules(composites: Composites) -> pd.DataFrame:
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
        ("certain", thesis.CERTAIN),
        ("by speed", thesis.BY_SPEED),
        ("apart", thesis.APART),
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


def explain_errors(composites: Composites) -> dict[str, int]:
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
    printed = thesis.direction_table()[missed["direction1"] - 1, missed["direction2"] - 1]
    by_level = (printed == thesis.BY_SPEED) & (missed["rule"] == thesis.APART)
    alike = missed["level1"] == missed["level2"]
    counts = {
        "false yes": len(wrong),
        "video ends first": late.sum(),
        "miss in time": (~late).sum(),
        "missed": len(missed),
        "levels alike": (by_level & alike).sum(),
        "one ahead faster": (by_level & ~alike).sum(),
        "departing": (printed == thesis.APART).sum(),
        "out of frame": (missed["rule"] == thesis.BY_SPEED).sum(),
    }
    return {name: int(count) for name, count in counts.items()}


def judge_table(
    composites: Composites, *, in_time: bool = False, draws: int = 1000, seed: int = 0
) -> dict[str, Estimate | None]:
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
    known, table = composites.known, composites.table
    if not known.any():
        raise ArgumentError("composites holds no composite in which S1 and S2 are told apart.")
    said, truth = table["said"].to_numpy(), table["occludes"].to_numpy()
    if in_time:
        said = said & (table["said_seconds"] <= table["left"]).to_numpy()
    couples = draw_pairs(
        composites.people("first"), composites.people("second"), draws=draws, seed=seed
    )
    parts = {
        "right": (said == truth, known),
        "precision": (said & truth, said),
        "recall": (said & truth, truth),
    }
    return {
        name: share_by_pair(hit & known, every & known, couples)
        for name, (hit, every) in parts.items()
    }


def _told_apart(composites):
    """The composites in which S1 and S2 are told apart."""
    return composites.table[composites.known]
