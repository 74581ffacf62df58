"""How well flow and traces agree with the truth."""

import pandas as pd

from mcnlab.errors import ArgumentError
from mcnlab.statistics import mean_by_subject, median_by_subject
from mcnlab.tables import FRAME, TRACE
from mcnlab.vision import flow


def flow_errors(sequences: dict[str, tuple]) -> pd.DataFrame:
    """The mean end-point error of every optical flow on every sequence, pixels.

    Parameters
    ----------
    sequences : dict
        Name → (first, second, truth), as from `recordings.flow_sequences`.

    Returns
    -------
    pandas.DataFrame
        One row a sequence, one column a method of `flow.METHODS`.
    """
    rows = {
        name: {
            method: flow.end_point_error(find(first, second), truth)
            for method, find in flow.METHODS.items()
        }
        for name, (first, second, truth) in sequences.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index")


def judge_traces(points: pd.DataFrame, feet: pd.DataFrame, *, first: int = 0) -> dict:
    """Recall, precision and error of traces, with intervals that draw whole walkers.

    Parameters
    ----------
    points : pandas.DataFrame
        Trace points: ``trace, frame, matched, error``.
    feet : pandas.DataFrame
        True feet: ``trace, frame, found, error``.
    first : int, optional
        Frames before this one are not judged.

    Returns
    -------
    dict of str to Estimate
        ``recall``, ``precision`` and ``median_error_m``, the median distance of the pairs.
    """
    points, feet = points[points[FRAME] >= first], feet[feet[FRAME] >= first]
    if len(points) == 0 or len(feet) == 0:
        raise ArgumentError(f"first is {first}: there is nothing to judge from there on; lower it.")
    pairs = feet[feet["found"].astype(bool)]
    if len(pairs) == 0:
        raise ArgumentError("feet: none was found; there is no distance to take a median of.")
    return {
        "recall": mean_by_subject(feet["found"], feet[TRACE]),
        "precision": mean_by_subject(points["matched"], points[TRACE]),
        "median_error_m": median_by_subject(pairs["error"], pairs[TRACE]),
    }
