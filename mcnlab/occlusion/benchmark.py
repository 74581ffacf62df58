"""The benchmark of occlusion foresight: who foresees best, on every recording at hand.

Each recording of boxes gives a table of pairs: what happened, what each forecaster said of
it, and the features that `forecasters.Learned` learns from.  Everything that is learned or
chosen, the regression and the thresholds, comes from the other recordings made by unmoved
cameras and of other people; recordings of the same people teach no more than one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from mcnlab.checks import require_choice
from mcnlab.datasets import motchallenge
from mcnlab.datasets.catalogue import BUNDLED, MOTCHALLENGE, dataset_folder, read_table
from mcnlab.datasets.motchallenge import place_of
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, McnError
from mcnlab.occlusion.forecasters import (
    FEATURES,
    ConstantVelocity,
    Learned,
    Perspective,
    Thesis,
    UncertainVelocity,
    describe,
)
from mcnlab.occlusion.pairs import RULES, Pairs, Rules, find_pairs, lay_over
from mcnlab.occlusion.scores import best_threshold, difference, score
from mcnlab.occlusion.thesis import SIDES
from mcnlab.results import Results
from mcnlab.synthetic.crossings import make_crossings
from mcnlab.tables import check_columns
from mcnlab.vision.camera_motion import moves

METHODS = ("thesis", "constant-velocity", "uncertain-velocity", "perspective", "learned")
DEFAULT = "learned"  # the one to use
MOST = 6000  # near pairs of one recording that have their full weight in learning
ASKED = ("direction1", "direction2", "level1", "level2")  # of the thesis's tables

# What is read of a table of pairs.
NEEDED = (
    *("recording", "first", "second", "occludes", "seconds", "near", "moving"),
    *(f"{name}.{value}" for name in METHODS[:-1] for value in ("probability", "seconds")),
    *(f"{name}.place_error" for name in METHODS[:-1]),
    *FEATURES,
)


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
        (recording, method) → `scores.Scores`.
    gains : dict
        (recording, method) → `scores.Difference`: `DEFAULT` less that method.
    moving : dict
        Recording → whether its camera moves.
    left_out : tuple of str
        What could not be scored, one sentence each.
    """

    table: pd.DataFrame
    thresholds: pd.DataFrame
    scores: dict
    gains: dict
    moving: dict
    left_out: tuple = ()

    @property
    def recordings(self) -> list[str]:
        """The recordings' names, those of unmoved cameras first."""
        return sorted(self.moving, key=lambda name: self.moving[name])

    @property
    def static(self) -> list[str]:
        """The recordings made by unmoved cameras."""
        return [name for name in self.recordings if not self.moving[name]]

    def of(self, recording: str) -> pd.DataFrame:
        """The pairs of one recording."""
        return self.table[self.table["recording"] == recording]

    @property
    def videos(self) -> list[str]:
        """The real videos among those of unmoved cameras."""
        return [name for name in self.static if name not in (COMPOSITES, CROSSINGS)]

    def mean(
        self, method: str, measure: str, recordings: Sequence[str] | None = None
    ) -> float | None:
        """A score's mean over recordings, those of unmoved cameras if none are named.

        None where there is none.
        """
        recordings = self.static if recordings is None else recordings
        values = [getattr(self.scores[name, method], measure).value for name in recordings]
        values = [value for value in values if value is not None]
        return float(np.mean(values)) if values else None

    def table_of(self, measure: str) -> pd.DataFrame:
        """A score of every method on every recording: recording × method, None where none."""
        return pd.DataFrame(
            {
                method: {
                    name: getattr(self.scores[name, method], measure).value
                    for name in self.recordings
                }
                for method in METHODS
            }
        )

    def report(self, results: Results) -> None:
        """Add every score, and what `DEFAULT` gains, to a notebook's results.

        Parameters
        ----------
        results : results.Results
        """
        for name in self.recordings:
            data = f"{name}, {len(self.of(name))} pairs" + ", moving camera" * self.moving[name]
            for method in METHODS:
                for measure, found in self.scores[name, method]._asdict().items():
                    held = None if found.value is None else found
                    unit = {"time_error_s": "seconds", "place_error": "bodies"}.get(measure, "")
                    results.add(f"occlusion.{name}.{method}.{measure}", held, unit=unit, data=data)
            for method in METHODS:
                if method != DEFAULT:
                    for measure, found in self.gains[name, method]._asdict().items():
                        results.add(f"occlusion.{name}.gain.{method}.{measure}", found, data=data)
        for part, recordings in {"mean": self.static, "videos": self.videos}.items():
            data = f"mean over {len(recordings)} recordings of unmoved cameras"
            for method in METHODS:
                for measure in ("f1", "ap", "calibration_error"):
                    mean = self.mean(method, measure, recordings)
                    results.add(f"occlusion.{part}.{method}.{measure}", mean, data=data)
            for method in METHODS:
                if method != DEFAULT and recordings:
                    best, other = (self.mean(one, "f1", recordings) for one in (DEFAULT, method))
                    results.add(f"occlusion.{part}.gain.{method}.f1", best - other, data=data)


def judge(
    tables: Sequence[pd.DataFrame],
    *,
    also: Sequence[pd.DataFrame] = (),
    draws: int = 400,
    seed: int = 0,
) -> Judged:
    """Learn, choose thresholds and score, always without the recording that is judged.

    Parameters
    ----------
    tables : list of pandas.DataFrame
        As `compare` gives them, each recording's own.  A recording in which no
        pair occludes cannot be scored and is left out.
    also : list of pandas.DataFrame, optional
        Further recordings to learn from, which are not scored: those of places that `tables`
        do not hold.
    draws : int, optional
        Of the bootstrap.
    seed : int, optional

    Returns
    -------
    Judged

    Raises
    ------
    McnError
        When no pair of any table occludes, there is no unmoved camera elsewhere to learn
        from, a recording is there twice, a table holds two recordings or lacks a column, or
        the near pairs of the other recordings all occlude or none does.

    Examples
    --------
    >>> from mcnlab import occlusion
    >>> from mcnlab.occlusion.benchmark import bundled_pairs
    >>> judged = occlusion.judge(bundled_pairs()[-2:], draws=20)
    >>> list(judged.recordings)
    ['pets09-s2l1', 'tud-stadtmitte']
    """
    for table in (*tables, *also):
        check_columns(table, NEEDED, argument="tables")
        if len(set(table["recording"])) > 1:
            raise ArgumentError("tables hold two recordings in one; pass one table a recording.")
    left_out = tuple(
        f"{table['recording'].iloc[0]} was not scored: none of its {len(table)} pairs occludes."
        for table in tables
        if not table["occludes"].any()
    )
    tables = [table for table in tables if table["occludes"].any()]
    moving = {table["recording"].iloc[0]: bool(table["moving"].any()) for table in tables}
    if len(moving) < len(tables):
        raise ArgumentError("tables hold a recording twice; pass each once.")
    if not tables:
        raise ArgumentError("tables hold no pair that occludes; pass longer recordings, or more.")
    named = dict(zip(moving, tables, strict=True))
    at_hand = {place_of(name) for name in named}
    elsewhere = [table for table in also if place_of(table["recording"].iloc[0]) not in at_hand]
    teachers = [
        table
        for table in (*named.values(), *elsewhere)
        if table["occludes"].any() and not table["moving"].any()
    ]
    chosen, scores, gains, judged = {}, {}, {}, []
    for name in named:
        others = [
            table for table in teachers if place_of(table["recording"].iloc[0]) != place_of(name)
        ]
        if not others:
            raise ArgumentError(
                f"tables hold nothing to learn from for {name}; it takes another place, with "
                "occlusions, that an unmoved camera filmed. Pass more, or some as also."
            )
        model = learn(others)
        # The thresholds know the others only; so does the regression behind "learned".
        table, *others = (with_learned(held, model) for held in (named[name], *others))
        judged.append(table)
        for method in METHODS:
            chosen[name, method] = choose_threshold(others, method)
        truth = truth_of(table)
        ours = forecast_of(table, DEFAULT)
        for method in METHODS:
            said = forecast_of(table, method)
            scores[name, method] = score(
                truth, said, threshold=chosen[name, method], draws=draws, seed=seed
            )
            if method != DEFAULT:
                gains[name, method] = difference(
                    truth,
                    ours,
                    said,
                    thresholds=(chosen[name, DEFAULT], chosen[name, method]),
                    draws=draws,
                    seed=seed,
                )
    thresholds = pd.DataFrame(
        {method: {name: chosen[name, method] for name in named} for method in METHODS}
    )
    return Judged(pd.concat(judged, ignore_index=True), thresholds, scores, gains, moving, left_out)


def summarise(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """What the recordings hold: pairs, how many occlude, people, whether the camera moves."""
    rows = {
        table["recording"].iloc[0]: {
            "pairs": len(table),
            "occlude": int(table["occludes"].sum()),
            "share": table["occludes"].mean(),
            "people": _count_people(table),
            "moving": bool(table["moving"].any()),
        }
        for table in tables
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("recording")


def _count_people(table):
    return len(pd.unique(table[["first", "second"]].to_numpy().ravel()))


def learn(tables: Sequence[pd.DataFrame]) -> Learned:
    """`forecasters.Learned`, fitted on tables of pairs.

    Far pairs teach nothing; a recording with very many near ones counts no more than one
    with `MOST`, and recordings of the same people share what one would count.

    Examples
    --------
    >>> from mcnlab import occlusion, synthetic
    >>> from mcnlab.occlusion.benchmark import bundled_pairs
    >>> model = occlusion.learn(bundled_pairs())
    >>> square = synthetic.make_crossings(people=12, seconds=12)
    >>> forecast = model.forecast(occlusion.watch(square, 100))
    >>> forecast.probability[:3].round(1).tolist()
    [0.0, 0.0, 0.0]
    """
    near = [table[table["near"]] for table in tables]
    weights = [
        np.full(len(table), min(1.0, MOST / max(len(table), 1)) / alike)
        for table, alike in zip(near, _alike(tables), strict=True)
    ]
    table = pd.concat(near, ignore_index=True)
    return Learned().fit(table[list(FEATURES)], table["occludes"], weights=np.concatenate(weights))


def choose_threshold(tables: Sequence[pd.DataFrame], method: str) -> float:
    """The threshold with the best F1 on tables of pairs, recordings counting by their people.

    Recordings of the same people share what one would count.
    """
    said = f"{method}.probability"
    table = pd.concat([held[["recording", "occludes", said]] for held in tables])
    people = {
        held["recording"].iloc[0]: _count_people(held) / alike
        for held, alike in zip(tables, _alike(tables), strict=True)
    }
    return best_threshold(table["occludes"], table[said], table["recording"], say=people)


class Experience(NamedTuple):
    """The table that the thesis made by hand, counted: D(S1) × D(S2) × V(S1) × V(S2)."""

    pairs: np.ndarray  # (8, 8, 3, 3)
    occluding: np.ndarray  # (8, 8, 3, 3), how many of them

    def by_direction(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs and occluding ones over directions alone, (8, 8) each."""
        return self.pairs.sum(axis=(2, 3)), self.occluding.sum(axis=(2, 3))

    def by_speed(self, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Pairs and occluding ones over speed levels, both going to one side, (3, 3) each.

        `side` is "right" or "left", as in `thesis.speed_table`.
        """
        require_choice("side", side, tuple(SIDES))
        at = np.array(SIDES[side]) - 1
        cells = np.ix_(at, at)
        return self.pairs[cells].sum(axis=(0, 1)), self.occluding[cells].sum(axis=(0, 1))


def count_experience(table: pd.DataFrame) -> Experience:
    """What became of pairs, by what the thesis's tables were asked of them.

    Parameters
    ----------
    table : pandas.DataFrame
        Pairs as `compare` gives them.

    Returns
    -------
    Experience

    Raises
    ------
    McnError
        When a column is missing, or a direction or a level is none.
    """
    check_columns(table, (*ASKED, "occludes"), argument="table")
    pairs, occluding = np.zeros((8, 8, 3, 3), int), np.zeros((8, 8, 3, 3), int)
    asked = table[list(ASKED)].to_numpy(float).T
    for name, value, most in zip(ASKED, asked, pairs.shape, strict=True):
        # A direction of 0 would count as 8.
        if not np.isin(value, np.arange(1, most + 1)).all():
            raise ArgumentError(f"table.{name} must hold whole numbers from 1 to {most}.")
    asked = asked.astype(int) - 1
    np.add.at(pairs, tuple(asked), 1)
    np.add.at(occluding, tuple(asked), table["occludes"].to_numpy(int))
    return Experience(pairs, occluding)


def truth_of(table: pd.DataFrame) -> pd.DataFrame:
    """What `scores.score` asks of the truth.

    Places are kept as errors, in body heights: the truth is at 0, and 1 is a body's height.
    """
    return table[["occludes", "seconds", "first", "second"]].assign(x=0.0, y=0.0, height=1.0)


def forecast_of(table: pd.DataFrame, method: str) -> pd.DataFrame:
    """What `scores.score` asks of a forecast; see `truth_of`."""
    names = {f"{method}.{name}": name for name in ("probability", "seconds")}
    held = table[list(names)].rename(columns=names)
    return held.assign(x=table[f"{method}.place_error"], y=0.0)


def _alike(tables):
    """Of each table, how many show the same people."""
    places = [place_of(table["recording"].iloc[0]) for table in tables]
    return [places.count(place) for place in places]


def with_learned(table: pd.DataFrame, model: Learned) -> pd.DataFrame:
    """A table of pairs with what a fitted `Learned` says of them."""
    near = table["near"].to_numpy()
    probability = table["perspective.probability"].to_numpy().copy()
    probability[near] = model.predict_probability(
        table.loc[near, list(FEATURES)], probability[near]
    )
    # The regression says when and where no better than the closed form.
    return table.assign(
        **{
            "learned.probability": probability,
            "learned.seconds": table["perspective.seconds"],
            "learned.place_error": table["perspective.place_error"],
        }
    )


def video_pairs() -> tuple[list[pd.DataFrame], tuple[str, ...]]:
    """Pairs of people in videos, and what forecasters said of them.

    Returns
    -------
    tables : list of pandas.DataFrame
        One a recording, as `compare` gives them: every MOTChallenge sequence
        under ``MCNLAB_DATA``, or those that came with mcnlab.
    problems : tuple of str
        What was left out, one sentence each.

    Raises
    ------
    McnError
        When files are damaged beyond leaving a sequence out.
    """
    folder = dataset_folder(MOTCHALLENGE)
    if folder is None:
        return bundled_pairs(), ()
    tables, problems = compare_sequences(folder)
    if tables:
        return tables, problems
    nothing = f"{MOTCHALLENGE} holds no sequence that can be used; the bundled forecasts stand in."
    return bundled_pairs(), (*problems, nothing)


def bundled_pairs() -> list[pd.DataFrame]:
    """The tables of `video_pairs` that came with mcnlab, one a recording."""
    path = BUNDLED / MOTCHALLENGE / "pairs.csv.gz"
    held = read_table(path, dtype={"first": str, "second": str})
    return [table.reset_index(drop=True) for _, table in held.groupby("recording")]


COMPOSITES, CROSSINGS = "composites", "crossings"
SHIFTS = (0, 12, 25)  # frames by which the second walk of a composite begins later
DECIMALS, FIGURES = 4, 6  # to which numbers and probabilities are kept
CROSSING_PEOPLE, CROSSING_SECONDS, CROSSING_SEED = 60, 60.0, 7


def compare(pairs: Pairs, *, name: str | None = None, moving: bool = False) -> pd.DataFrame:
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
        where ``near`` the features of `forecasters.describe`, otherwise 0; and ``moving``
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


def compare_composites(recording: Recording, *, rules: Rules = RULES) -> pd.DataFrame:
    """`compare` over every composite of two walks of one recording."""
    return compare(lay_over(recording, shifts=SHIFTS, rules=rules), name=COMPOSITES)


def compare_crossings(*, rules: Rules = RULES) -> pd.DataFrame:
    """`compare` over synthetic people who cross a square."""
    made = make_crossings(people=CROSSING_PEOPLE, seconds=CROSSING_SECONDS, seed=CROSSING_SEED)
    return compare(find_pairs(made, rules=rules), name=CROSSINGS)


def compare_sequences(
    folder: str | Path, *, rules: Rules = RULES, n_jobs: int = 1
) -> tuple[list[pd.DataFrame], tuple[str, ...]]:
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
