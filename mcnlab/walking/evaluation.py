"""How the methods are judged: the same walks, the same questions, an interval each."""

import itertools
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from time import perf_counter

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.checks import require_count
from mcnlab.compass import direction_of, heading_of, turn_between
from mcnlab.datasets import casia
from mcnlab.datasets.catalogue import casia_a_folder
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError, SilhouetteError
from mcnlab.statistics import (
    Estimate,
    accuracy,
    draw_people,
    interval_of,
    mean_by_subject,
    share_by_subject,
    share_of,
)
from mcnlab.synthetic.noise import SegmentationNoise, add_noise
from mcnlab.synthetic.walkers import CASIA_VIEW, SyntheticWalk, make_walks
from mcnlab.tables import DIRECTION, SEQUENCE
from mcnlab.vision.silhouettes import measure_sequence
from mcnlab.walking import viewpoint
from mcnlab.walking.direction import (
    LinearSeparators,
    group_of,
    leave_one_subject_out,
    measure_phase_space,
    phase_space_classifier,
)
from mcnlab.walking.heading import degrees_of_freedom, measure_headings
from mcnlab.walking.phase import SOFT_RULES, measure_phases

# The noise that the closed form must stand: level 1 of the noise figure.
HARD_NOISE = SegmentationNoise(
    specks=20, speck_size=(2, 8), cut_limbs=1, cut_share=1.0, missing=0.05
)


def truth_of(recording: Recording, sequences: ArrayLike | None = None) -> np.ndarray:
    """True directions 1 … 8, one a sequence named (each of the recording's if None)."""
    if recording.directions is None:
        raise ArgumentError(f"{recording.name} has no direction labels; pass a labelled recording.")
    names = recording.sequences if sequences is None else sequences
    return recording.directions[names].to_numpy()


def is_own(recording: Recording, sequences: ArrayLike | None = None) -> np.ndarray:
    """False for mirrored copies: one flag a sequence named."""
    names = recording.sequences if sequences is None else sequences
    return ~np.isin(np.asarray(names, dtype=object), list(recording.copies))


def judge_phase(recording: Recording, phases: ArrayLike) -> tuple[Estimate, Estimate | None]:
    """Judge one phase as the thesis does, and honestly.

    Parameters
    ----------
    recording : Recording
        With labels.
    phases : pandas.Series or array_like, shape (n,)
        One a sequence, in the recording's order.

    Returns
    -------
    resubstitution, loso : Estimate
        Share of the five groups told right by separators that were placed on the same
        videos, and by separators placed without the subject's.  Mirrored copies count
        in the share, not in the interval.  With one subject, the latter is None.
    """
    phases = np.asarray(phases, dtype=float)
    groups = group_of(truth_of(recording))
    fitted = LinearSeparators().fit(phases, groups).predict(phases)
    own = is_own(recording)
    resubstitution = accuracy(fitted == groups, own=own)
    subjects = recording.subjects.to_numpy()
    if len(set(subjects)) < 2:
        return resubstitution, None
    left_out = leave_one_subject_out(LinearSeparators(), phases, groups, subjects)
    return resubstitution, accuracy(left_out == groups, own=own)


def sweep_thresholds(
    recording: Recording,
    *,
    prominences: Iterable[float],
    spacings: Iterable[int],
    soft_rules: Iterable[str] = SOFT_RULES,
) -> pd.DataFrame:
    """Resubstitution of the thesis's phases under many rules for extrema.

    The thesis names none; this shows what any choice could have given.

    Parameters
    ----------
    recording : Recording
        With labels.
    prominences, spacings, soft_rules : iterable
        Options of `phase.measure_phases`, each combined with every other.

    Returns
    -------
    pandas.DataFrame
        ``soft_rule, spacing, prominence, height, width``: shares right.
    """
    rows = []
    for rule, spacing, prominence in itertools.product(soft_rules, spacings, prominences):
        measured = measure_phases(
            recording.boxes, prominence=prominence, spacing=spacing, soft_rule=rule
        )
        groups = group_of(truth_of(recording, measured.index))
        shares = [
            LinearSeparators().fit(measured[column], groups).score(measured[column], groups)
            for column in ("m_h", "m_w")
        ]
        rows.append((rule, spacing, prominence, *shares))
    return pd.DataFrame(rows, columns=["soft_rule", "spacing", "prominence", "height", "width"])


def judge_phase_space(recording: Recording) -> tuple[Estimate | None, np.ndarray | None]:
    """Eight directions from several phases, one subject left out at a time.

    Parameters
    ----------
    recording : Recording
        With labels.

    Returns
    -------
    estimate : Estimate or None
        None with one subject.
    said : ndarray or None
        The direction said of each sequence.
    """
    if recording.subjects.nunique() < 2:
        return None, None
    space = measure_phase_space(recording)
    truth = truth_of(recording, space.index)
    subjects = recording.subjects[space.index].to_numpy()
    said = leave_one_subject_out(phase_space_classifier(), space.to_numpy(), truth, subjects)
    return accuracy(said == truth, own=is_own(recording, space.index)), said


def judge_headings(
    recording: Recording, headings: pd.DataFrame
) -> tuple[Estimate, Estimate, np.ndarray]:
    """Judge headings against direction labels.

    Parameters
    ----------
    recording : Recording
        With labels.
    headings : pandas.DataFrame
        From `heading.measure_headings`.

    Returns
    -------
    right : Estimate
        Share of directions right; a walk without any heading counts as wrong.
    error : Estimate
        Mean absolute error, degrees, bootstrapped by subject.
    errors : ndarray
        Signed, degrees.
    """
    names = headings[SEQUENCE].to_numpy()
    truth = truth_of(recording, names)
    errors = turn_between(headings["heading"].to_numpy(), heading_of(truth))
    silent = [name for name in recording.sequences if name not in set(names)]
    right = accuracy(
        np.r_[headings[DIRECTION].to_numpy() == truth, np.zeros(len(silent), bool)],
        own=is_own(recording, [*names, *silent]),
    )
    subjects = recording.subjects[names].to_numpy()
    return right, mean_by_subject(np.abs(errors), subjects), errors


def judge_pets(headings: pd.DataFrame, *, least_speed: float = 0.6) -> dict[str, Estimate]:
    """Judge PETS 2009 headings against world truth.

    Parameters
    ----------
    headings : pandas.DataFrame
        From `outdoors.pets2009_headings`.
    least_speed : float, optional
        m/s; who hardly moves has no heading.

    Returns
    -------
    dict
        ``direction8``, ``within45`` and ``mae_deg``, each an `Estimate`.
    """
    moving = headings[headings["true_speed"] > least_speed]
    if moving.empty:
        raise ArgumentError(
            f"headings: nobody is faster than {least_speed} m/s; lower least_speed."
        )
    error = moving["error"].to_numpy()
    said, true = (direction_of(moving[column]) for column in ("sight", "true_sight"))
    return {
        "direction8": accuracy(said == true),
        "within45": accuracy(np.abs(error) <= 45),
        "mae_deg": mean_by_subject(np.abs(error), moving[SEQUENCE]),
    }


def record_walks(
    walks: Sequence[SyntheticWalk],
    *,
    noise: SegmentationNoise | None = None,
    seed: int = 0,
    name: str = "synthetic",
    n_jobs: int = 1,
) -> Recording:
    """Measure synthetic walks as real ones are, through noise if wanted.

    Parameters
    ----------
    walks : list of SyntheticWalk
        From one kind of camera.
    noise : SegmentationNoise, optional
    seed : int, optional
        Of the noise.
    name : str, optional
    n_jobs : int, optional
        Processes, as joblib counts them.

    Returns
    -------
    Recording
        With the directions nearest to the true headings as labels.  A walk in which no
        frame shows one walker is left out and named in ``problems``.
    """
    from joblib import Parallel, delayed

    if not walks:
        raise ArgumentError("walks is empty; pass at least one.")
    # Threads: OpenCV lets go of the interpreter, and the masks need not be copied.
    measured = Parallel(n_jobs=n_jobs, prefer="threads")(
        delayed(_measure_walk)(walk, noise, seed + number) for number, walk in enumerate(walks)
    )
    tables = [table for table, _ in measured if table is not None]
    if not tables:
        raise ArgumentError("noise hides every walker; turn it down.")
    boxes = pd.concat(tables, ignore_index=True)
    view, kept = walks[0].view, set(boxes[SEQUENCE])
    return Recording(
        name,
        boxes,
        walks[0].walk.frame_rate,
        view.frame_width,
        view.frame_height,
        directions=pd.Series({walk.name: walk.direction for walk in walks if walk.name in kept}),
        problems=tuple(problem for _, problem in measured if problem),
    )


def accuracy_under_noise(
    levels: Iterable[float],
    *,
    subjects: int = 8,
    noise: SegmentationNoise = HARD_NOISE,
    seed: int = 0,
    focal_length: float | None = None,
    n_jobs: int = -1,
) -> dict[str, list[Estimate]]:
    """Accuracy of three methods on synthetic walkers, as segmentation gets worse.

    The separators of the thesis's phase and of the growth rate are placed on noise-free
    walks of other people; the closed form learns nothing.

    Parameters
    ----------
    levels : sequence of float
        Multiples of `noise`.
    subjects : int, optional
        People to test on; as many others to learn from.
    noise : SegmentationNoise, optional
    seed : int, optional
    focal_length : float, optional
        Pixels; the synthetic camera's own if not given.
    n_jobs : int, optional

    Returns
    -------
    dict
        ``"thesis, height"`` and ``"growth"`` (five groups), ``"perspective"`` (eight
        directions) → list of `Estimate`, one a level.  A walk that could not be
        measured counts as wrong.
    """
    subjects = require_count("subjects", subjects, low=1)
    walks = make_walks(subjects=2 * subjects, seed=seed)
    half = 8 * subjects
    learn = record_walks(walks[:half], n_jobs=n_jobs)
    groups = group_of(truth_of(learn))
    thesis = LinearSeparators().fit(measure_phases(learn.boxes)["m_h"].to_numpy(), groups)
    growth = LinearSeparators().fit(measure_phase_space(learn)["height_growth"].to_numpy(), groups)
    focal_length = CASIA_VIEW.focal_length if focal_length is None else focal_length
    found = {"thesis, height": [], "growth": [], "perspective": []}
    for level in levels:
        seen = record_walks(walks[half:], noise=noise.scaled(level), seed=seed + 1, n_jobs=n_jobs)
        truth = truth_of(seen)
        slopes = measure_phases(seen.boxes)["m_h"].to_numpy()
        rates = measure_phase_space(seen)["height_growth"].to_numpy()
        headings = measure_headings(seen, focal_length=focal_length)
        true_way = truth_of(seen, headings[SEQUENCE].to_numpy())
        right = {
            "thesis, height": thesis.predict(slopes) == group_of(truth),
            "growth": growth.predict(rates) == group_of(truth),
            "perspective": headings[DIRECTION].to_numpy() == true_way,
        }
        for method, flags in right.items():
            lost = np.zeros(half - len(flags), dtype=bool)
            found[method].append(accuracy(np.r_[flags, lost]))
    return found


def half_peak(
    measured: pd.DataFrame, truth: pd.DataFrame, *, seed: int = 0, draws: int = 200
) -> Estimate:
    """How far off square-on half of the gait's peak is lost, with an interval over people.

    Parameters
    ----------
    measured : pandas.DataFrame
        From `gait.measure_gait`.
    truth : pandas.DataFrame
        ``subject, angle``, indexed by sequence, as from `viewpoint.record_at_angles`.
    seed, draws : int, optional
        Of the bootstrap, which draws whole people.

    Returns
    -------
    Estimate
        Degrees from square-on.
    """
    whole = viewpoint.half_peak_angle(viewpoint.detectability(measured, truth["angle"]))
    peaks = measured["peak"].reindex(truth.index, fill_value=0.0)
    table = truth.assign(peak=peaks).pivot_table(
        index="subject", columns="angle", values="peak", aggfunc=list
    )
    angles = []
    for times in draw_people(len(table), draws=draws, seed=seed):
        drawn = table.iloc[np.repeat(np.arange(len(table)), times.astype(int))]
        medians = [np.median(np.concatenate(drawn[angle].tolist())) for angle in table.columns]
        angles.append(
            viewpoint.half_peak_angle(pd.DataFrame({"angle": table.columns, "peak": medians}))
        )
    low, high = interval_of(angles)
    return Estimate(90 - whole, 90 - high, 90 - low, len(table))


def steps_right(measured: pd.DataFrame, truth: pd.DataFrame, *, tolerance: float = 0.1) -> Estimate:
    """The share of walks whose step is found and right, with an interval over people.

    Parameters
    ----------
    measured : pandas.DataFrame
        From `gait.measure_gait`.
    truth : pandas.DataFrame
        ``subject, step_s``, indexed by sequence.
    tolerance : float, optional
        Share of the true step that a right one may be off.
    """
    found = measured.reindex(truth.index)
    near = np.abs(found["step_s"] - truth["step_s"]) <= tolerance * truth["step_s"]
    right = near & found["detectable"].eq(True)
    return share_by_subject(right, truth["subject"])


def neighbours_agree(headings: pd.DataFrame) -> Estimate:
    """How often neighbouring windows of a walk agree within their joint 95 % margin.

    Needs no truth: a walk that is straight has one heading.

    Parameters
    ----------
    headings : pandas.DataFrame
        Windows, from `heading.measure_headings`.

    Returns
    -------
    Estimate
        The interval counts disjoint pairs only.
    """
    names = headings[SEQUENCE].to_numpy()
    heading, margin = headings["heading"].to_numpy(), headings["margin"].to_numpy()
    pair = names[1:] == names[:-1]
    apart = np.abs(turn_between(heading[1:], heading[:-1]))[pair]
    if len(apart) == 0:
        raise ArgumentError("headings has no walk with two windows; pass shorter windows.")
    agree = apart <= np.hypot(margin[1:], margin[:-1])[pair]
    return share_of(agree.mean(), max(1, len(agree) // 2))


def calibration(
    headings: pd.DataFrame, true_headings: ArrayLike, *, levels: Iterable[float]
) -> list[Estimate]:
    """How often the interval of a given level holds the true heading.

    Parameters
    ----------
    headings : pandas.DataFrame
        From `heading.measure_headings`.
    true_headings : array_like
        Degrees, one a row.
    levels : sequence of float
        Nominal shares between 0 and 1.

    Returns
    -------
    list of Estimate
    """
    from scipy import stats

    errors = np.abs(turn_between(headings["heading"].to_numpy(), true_headings))
    # The margins are 95 % ones; the others follow by the ratio of the quantiles.
    freedom = degrees_of_freedom(headings["frames"].to_numpy())
    unit = headings["margin"].to_numpy() / stats.t.ppf(0.975, freedom)
    return [accuracy(errors <= unit * stats.t.ppf(0.5 + level / 2, freedom)) for level in levels]


def time_videos(
    sequences: list[casia.SilhouetteSequence] | None = None, *, focal_length: float, most: int = 40
) -> np.ndarray:
    """Seconds from image files to a heading, a video, on one core.

    Parameters
    ----------
    sequences : list of SilhouetteSequence, optional
        What to time; `sample_sequences` if not given.
    focal_length : float
        Pixels.
    most : int, optional
        At most so many videos, evenly spread.

    Returns
    -------
    ndarray
        Wall seconds a video.
    """
    with sample_sequences(most=most) if sequences is None else nullcontext(sequences) as chosen:
        seconds = []
        for sequence in chosen:
            begin = perf_counter()
            try:
                read_heading(sequence, focal_length=focal_length)
            except (DatasetError, SilhouetteError):
                continue  # damaged: left out here as everywhere
            seconds.append(perf_counter() - begin)
    if not seconds:
        raise ArgumentError("sequences: none could be read; restore their files.")
    return np.array(seconds)


def read_heading(sequence: casia.SilhouetteSequence, *, focal_length: float) -> pd.DataFrame:
    """One video, from its image files to the table of its heading."""
    boxes = measure_sequence(sequence.frames(), sequence=sequence.name, subject=sequence.subject)
    recording = Recording(
        casia.NAME, boxes, casia.FRAME_RATE, casia.FRAME_WIDTH, casia.FRAME_HEIGHT
    )
    return measure_headings(recording, focal_length=focal_length)


@contextmanager
def sample_sequences(*, most: int = 40, seed: int = 0) -> Iterator[list[casia.SilhouetteSequence]]:
    """CASIA A sequences to time: real ones, or synthetic ones in a folder that goes again."""
    folder = casia_a_folder()
    if folder is not None:
        found = casia.find_sequences(folder)
        places = np.unique(np.linspace(0, len(found) - 1, min(most, len(found))).astype(int))
        yield [found[place] for place in places]
        return
    with tempfile.TemporaryDirectory() as made:
        for walk in make_walks(subjects=max(1, most // 8), seed=seed):
            casia.write_silhouettes(made, walk.subject, walk.name.split("-")[1], walk.masks)
        yield casia.find_sequences(made)


def _measure_walk(walk, noise, seed):
    masks = walk.masks if noise is None else add_noise(walk.masks, noise, seed=seed)
    try:
        return measure_sequence(masks, sequence=walk.name, subject=walk.subject), None
    except SilhouetteError as fault:
        return None, f"{walk.name}: {fault}"
