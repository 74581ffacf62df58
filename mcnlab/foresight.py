"""The benchmark of occlusion foresight: who foresees best, on every recording at hand.

Each recording of boxes gives a table of pairs: what happened, what each forecaster said of
it, and the features that `prediction.Learned` learns from.  Everything that is learned or
chosen, the regression and the thresholds, comes from the other recordings made by unmoved
cameras; recordings of the same people count as one.
"""

import re
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mcnlab import scoring
from mcnlab.datasets import motchallenge
from mcnlab.datasets.crossings import make_crossings
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.pairs import RULES, find_pairs, lay_over
from mcnlab.prediction import (
    FEATURES,
    ConstantVelocity,
    Learned,
    Perspective,
    Thesis,
    describe,
)

METHODS = ("thesis", "constant-velocity", "perspective", "learned")
DEFAULT = "learned"  # the one to use
COMPOSITES, CROSSINGS = "composites", "crossings"
SHIFTS = (0, 12, 25)  # frames by which the second walk of a composite begins later
CROSSING_PEOPLE, CROSSING_SECONDS, CROSSING_SEED = 60, 60.0, 7
MOST = 6000  # pairs of one recording that have their full weight in learning


def compare(pairs, *, name=None):
    """What happened to each pair, and what the forecasters that learn nothing said of it.

    Parameters
    ----------
    pairs : pairs.Pairs
    name : str, optional
        The recording's, if not the pairs'.

    Returns
    -------
    pandas.DataFrame
        One row a pair: ``recording, frame, first, second`` (who), ``body`` (pixels of a
        body's height), ``occludes, seconds``; of each forecaster ``<name>.probability,
        <name>.seconds, <name>.place_error`` (body heights; 0 where they do not occlude);
        ``direction1, direction2, level1, level2`` (what the thesis's tables were asked);
        and where ``near`` the features of `prediction.describe`, otherwise 0.
    """
    outlook = Perspective().look_ahead(pairs)
    thesis = Thesis()
    forecasts = {
        "thesis": thesis.forecast(pairs),
        "constant-velocity": ConstantVelocity().forecast(pairs),
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
    features[outlook.near] = describe(outlook)[list(FEATURES)].to_numpy()
    return table.join(pd.DataFrame(features, columns=list(FEATURES))).assign(near=near)


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
        table = compare(find_pairs(recording, rules=rules))
    except DatasetError as fault:
        return None, str(fault)
    return table.assign(moving=motchallenge.moves(recording)), ""


def place_of(recording):
    """What recordings of the same people have in common, as a name.

    MOT16-02 and MOT17-02-DPM, -FRCNN and -SDP are one video.
    """
    found = re.fullmatch(r"mot1[67]-(\d+)(-.*)?", recording)
    return f"mot-{found[1]}" if found else recording


@dataclass(frozen=True)
class Judged:
    """How the forecasters did.

    Attributes
    ----------
    table : pandas.DataFrame
        One row a pair, as `compare` gives it, with ``learned.*``.
    thresholds : pandas.DataFrame
        Recording × method: chosen without the recording.
    scores : dict
        (recording, method) → `scoring.Scores`.
    gains : dict
        (recording, method) → `scoring.Difference`: `DEFAULT` less that method.
    moving : dict
        Recording → whether its camera moves.
    """

    table: pd.DataFrame
    thresholds: pd.DataFrame
    scores: dict
    gains: dict
    moving: dict

    @property
    def recordings(self):
        """The recordings' names, those of unmoved cameras first."""
        return sorted(self.moving, key=lambda name: self.moving[name])

    @property
    def static(self):
        """The recordings made by unmoved cameras."""
        return [name for name in self.recordings if not self.moving[name]]

    def of(self, recording):
        """The pairs of one recording."""
        return self.table[self.table["recording"] == recording]

    def mean(self, method, measure):
        """A score's mean over the recordings of unmoved cameras, or None where there is none."""
        values = [getattr(self.scores[name, method], measure).value for name in self.static]
        values = [value for value in values if value is not None]
        return float(np.mean(values)) if values else None


def judge(tables, *, draws=400, seed=0):
    """Learn, choose thresholds and score, always without the recording that is judged.

    Parameters
    ----------
    tables : list of pandas.DataFrame
        As `compare` gives them; of a moving camera with the column ``moving``.  A recording
        in which no pair occludes cannot be scored and is left out.
    draws : int, optional
        Of the bootstrap.
    seed : int, optional

    Returns
    -------
    Judged

    Raises
    ------
    ArgumentError
        When fewer than two unmoved cameras filmed pairs that occlude.
    """
    tables = [table for table in tables if table["occludes"].any()]
    moving = {
        table["recording"].iloc[0]: bool(table["moving"].any()) if "moving" in table else False
        for table in tables
    }
    tables = dict(zip(moving, tables, strict=True))
    if len({place_of(name) for name in tables if not moving[name]}) < 2:
        raise ArgumentError(
            f"tables hold {len(tables)} recordings with occlusions; learning from others needs "
            "two places that unmoved cameras filmed."
        )
    chosen, scores, gains, judged = {}, {}, {}, []
    for name in tables:
        others = _others(name, tables, moving)
        model = learn(others)
        # The thresholds know the others only; so does the regression behind "learned".
        table, *others = (with_learned(held, model) for held in (tables[name], *others))
        judged.append(table)
        for method in METHODS:
            chosen[name, method] = choose_threshold(others, method)
        truth = truth_of(table)
        ours = forecast_of(table, DEFAULT)
        for method in METHODS:
            said = forecast_of(table, method)
            scores[name, method] = scoring.score(
                truth, said, threshold=chosen[name, method], draws=draws, seed=seed
            )
            if method != DEFAULT:
                gains[name, method] = scoring.difference(
                    truth,
                    ours,
                    said,
                    thresholds=(chosen[name, DEFAULT], chosen[name, method]),
                    draws=draws,
                    seed=seed,
                )
    thresholds = pd.DataFrame(
        {method: {name: chosen[name, method] for name in tables} for method in METHODS}
    )
    return Judged(pd.concat(judged, ignore_index=True), thresholds, scores, gains, moving)


def learn(tables):
    """`prediction.Learned`, fitted on tables of pairs.

    Far pairs teach nothing; a recording with very many near ones counts no more than one
    with `MOST`.
    """
    near = [table[table["near"]] for table in tables]
    weights = [np.full(len(table), min(1.0, MOST / max(len(table), 1))) for table in near]
    table = pd.concat(near, ignore_index=True)
    return Learned().fit(table, table["occludes"], weights=np.concatenate(weights))


def choose_threshold(tables, method):
    """The threshold with the best F1 on tables of pairs, recordings counting by their people."""
    table = pd.concat(tables, ignore_index=True)
    people = {
        held["recording"].iloc[0]: float(len(np.unique(held[["first", "second"]].to_numpy(str))))
        for held in tables
    }
    return scoring.best_threshold(
        table["occludes"], table[f"{method}.probability"], table["recording"], say=people
    )


def truth_of(table):
    """What `scoring.score` asks of the truth.

    Places are kept as errors, in body heights: the truth is at 0, and 1 is a body's height.
    """
    return table[["occludes", "seconds", "first", "second"]].assign(x=0.0, y=0.0, height=1.0)


def forecast_of(table, method):
    """What `scoring.score` asks of a forecast; see `truth_of`."""
    names = {f"{method}.{name}": name for name in ("probability", "seconds")}
    held = table[list(names)].rename(columns=names)
    return held.assign(x=table[f"{method}.place_error"], y=0.0)


def _others(name, tables, moving):
    return [
        table
        for other, table in tables.items()
        if place_of(other) != place_of(name) and not moving[other]
    ]


def with_learned(table, model):
    """A table of pairs with what a fitted `Learned` says of them."""
    near = table["near"].to_numpy()
    probability = table["perspective.probability"].to_numpy().copy()
    probability[near] = model.predict_probability(table[near], probability[near])
    # The regression says when and where no better than the closed form.
    return table.assign(
        **{
            "learned.probability": probability,
            "learned.seconds": table["perspective.seconds"],
            "learned.place_error": table["perspective.place_error"],
        }
    )
