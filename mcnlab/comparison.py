"""One table a recording: what happened to each pair, and what each forecaster said of it.

Everything after this, learning, choosing thresholds and scoring (`mcnlab.foresight`), needs
these tables only: they hold probabilities, times, errors and relative features, but nobody's
boxes.
"""

import re

import numpy as np
import pandas as pd

from mcnlab.datasets import motchallenge
from mcnlab.datasets.cameramotion import moves
from mcnlab.datasets.crossings import make_crossings
from mcnlab.errors import McnError
from mcnlab.pairs import RULES, find_pairs, lay_over
from mcnlab.prediction import (
    FEATURES,
    ConstantVelocity,
    Perspective,
    Thesis,
    UncertainVelocity,
    describe,
)

COMPOSITES, CROSSINGS = "composites", "crossings"
SHIFTS = (0, 12, 25)  # frames by which the second walk of a composite begins later
DECIMALS, FIGURES = 4, 6  # to which numbers and probabilities are kept
CROSSING_PEOPLE, CROSSING_SECONDS, CROSSING_SEED = 60, 60.0, 7


def compare(pairs, *, name=None, moving=False):
    """What happened to each pair, and what the forecasters that learn nothing said of it.

    Parameters
    ----------
    pairs : pairs.Pairs
    name : str, optional
        The recording's, if not the pairs'.
    moving : bool, optional
        Whether the camera moves.

    Returns
    -------
    pandas.DataFrame
        One row a pair: ``recording, frame, first, second`` (who), ``body`` (pixels of a
        body's height), ``occludes, seconds``; of each forecaster ``<name>.probability,
        <name>.seconds, <name>.place_error`` (body heights; 0 where they do not occlude);
        ``direction1, direction2, level1, level2`` (what the thesis's tables were asked);
        where ``near`` the features of `prediction.describe`, otherwise 0; and ``moving``
        (whether the camera does).  Rounded as tables are kept.
    """
    outlook = Perspective().look_ahead(pairs)
    thesis = Thesis()
    forecasts = {
        "thesis": thesis.forecast(pairs),
        "constant-velocity": ConstantVelocity().forecast(pairs),
        "uncertain-velocity": UncertainVelocity().forecast(pairs),
        "perspective": outlook.forecast,
    }
    columns = {
        "recording": name or pairs.name,
        "frame": pairs.frame,
        "first": pairs.people[:, 0],
        "second": pairs.people[:, 1],
        "body": pairs.body,
        "occludes": pairs.occludes,
        "seconds": pairs.seconds,
    }
    for method, forecast in forecasts.items():
        apart = np.hypot(forecast.x - pairs.x, forecast.y - pairs.y) / pairs.body
        columns[f"{method}.probability"] = forecast.probability
        columns[f"{method}.seconds"] = forecast.seconds
        columns[f"{method}.place_error"] = np.where(pairs.occludes, apart, 0.0)
    table = pd.DataFrame(columns).join(thesis.explain(pairs)[1])
    near = np.zeros(len(pairs), bool)
    near[outlook.near] = True
    features = np.zeros((len(pairs), len(FEATURES)))
    features[outlook.near] = describe(outlook)
    table = table.join(pd.DataFrame(features, columns=list(FEATURES)))
    table = table.assign(near=near, moving=moving)
    for name in table.select_dtypes(float):
        values = table[name].to_numpy()
        # Small probabilities rank pairs too: rounding to decimals would make them equal.
        ranks = name.endswith(".probability")
        table[name] = _to_figures(values, FIGURES) if ranks else np.round(values, DECIMALS)
    return table


def _to_figures(values, figures):
    """Numbers from 0 to 1 rounded to so many significant figures."""
    size = np.floor(np.log10(np.maximum(values, 1e-30)))
    power = 10.0 ** (figures - 1 - size)
    return np.round(values * power) / power


def compare_composites(recording, *, rules=RULES):
    """`compare` over every composite of two walks of one recording."""
    return compare(lay_over(recording, shifts=SHIFTS, rules=rules), name=COMPOSITES)


def compare_crossings(*, rules=RULES):
    """`compare` over synthetic people who cross a square."""
    made = make_crossings(people=CROSSING_PEOPLE, seconds=CROSSING_SECONDS, seed=CROSSING_SEED)
    return compare(find_pairs(made, rules=rules), name=CROSSINGS)


def compare_sequences(folder, *, rules=RULES, n_jobs=1):
    """`compare` over every MOTChallenge sequence in a folder.

    Returns
    -------
    tables : list of pandas.DataFrame
    problems : tuple of str
        What was left out.
    """
    from joblib import Parallel, delayed

    recordings, problems = motchallenge.read_sequences(folder)
    done = Parallel(n_jobs=n_jobs)(delayed(_try)(recording, rules) for recording in recordings)
    tables = [table for table, _ in done if table is not None]
    return tables, (*problems, *(problem for _, problem in done if problem))


def _try(recording, rules):
    try:
        moving = moves(recording)
        return compare(find_pairs(recording, rules=rules), moving=moving), ""
    except McnError as fault:
        return None, f"{recording.name} was left out: {fault}"


# Videos of MOT15 that MOT16 and MOT17 have annotated anew: eight of equal length.
_ANEW = {
    "venice-1": "mot-01",
    "venice-2": "mot-02",
    "eth-pedcross2": "mot-05",
    "eth-linthescher": "mot-06",
    "adl-rundle-1": "mot-07",
    "adl-rundle-3": "mot-08",
    "adl-rundle-6": "mot-09",
    "adl-rundle-8": "mot-10",
}
# The eight videos of MOT20 show three scenes.
_CROWDS = {1: "hall", 2: "hall", 7: "hall", 3: "night", 4: "night", 5: "night", 6: "day", 8: "day"}


def place_of(recording):
    """What recordings that may show the same people have in common, as a name.

    MOT16-02, MOT17-02-DPM, -FRCNN and -SDP and MOT15's Venice-2 are one video; MOT20 has eight
    videos of three scenes; all of PETS 2009 was acted on one campus by the same people.

    Parameters
    ----------
    recording : str
        A recording's name, in any case.
    """
    name = str(recording).lower()
    if found := re.fullmatch(r"mot1[67](?:det)?-0*(\d+)(-.*)?", name):
        return f"mot-{int(found[1]):02d}"
    if found := re.fullmatch(r"mot20(?:det)?-0*(\d+)(-.*)?", name):
        number = int(found[1])
        return f"mot20-{_CROWDS.get(number, number)}"
    if re.match(r"pets(20)?09", name):
        return "pets-2009"
    return _ANEW.get(name, name)
