"""Recordings by name, measured anew where they lie at hand, or as bundled."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.checks import require_choice
from mcnlab.datasets import casia, middlebury, motchallenge, pets, trajectories
from mcnlab.datasets.catalogue import (
    BUNDLED,
    casia_a_folder,
    data_folder,
    dataset_folder,
    pets_video_files,
    read_table,
)
from mcnlab.datasets.kept import Kept
from mcnlab.datasets.mirror import SUFFIX, add_mirrored, mirror_direction, mirror_masks
from mcnlab.datasets.recording import Recording
from mcnlab.datasets.scene import Scene, area_of
from mcnlab.datasets.video import open_video
from mcnlab.errors import DatasetError, SilhouetteError
from mcnlab.synthetic import corridor
from mcnlab.synthetic.noise import SegmentationNoise, add_noise
from mcnlab.synthetic.shifts import MOTIONS, make_motion
from mcnlab.synthetic.street import STREET_NAME, make_street
from mcnlab.synthetic.walkers import make_walks
from mcnlab.tables import FRAME, SEQUENCE, SUBJECT, TRACE, WORLD_X, WORLD_Y, X, Y, check_boxes
from mcnlab.vision import traces
from mcnlab.vision.silhouettes import MIN_AREA, find_body, measure_sequences

# The finders of people that are held against each other; the thesis's is that of 1981.
PETS_FINDERS = {
    "background": "background",
    "horn-schunck": "horn-schunck-plain",
    "dis": "dis",
    "farneback": "farneback",
}

PETS_HALF = 397  # frames: what was tuned saw the frames before this one only
# Brief losses of a limb, holes and specks: what rectification can mend.
EXAMPLE_NOISE = SegmentationNoise(specks=4, speck_size=(3, 8), holes=4, cut_limbs=4, cut_share=0.04)


def casia_a(*, mirrored: bool = True, progress: bool = False) -> Recording:
    """CASIA Dataset A as a recording, mirrored to eight directions.

    Parameters
    ----------
    mirrored : bool, optional
        Add the mirror images of the oblique walks (thesis section 3.1).
    progress : bool, optional
        Show a progress bar while measuring.

    Returns
    -------
    Recording

    Raises
    ------
    DatasetError
        When files are missing or nothing can be measured; a damaged sequence is left
        out and named in ``problems``.

    Examples
    --------
    >>> recording = casia_a(mirrored=False)
    >>> recording.name, recording.frame_rate
    ('casia-a', 25.0)
    """
    folder = casia_a_folder()
    if folder is None:
        recording = read_casia_a(BUNDLED / casia.NAME)
    else:
        recording = measure_casia_a(folder, progress=progress)
    return add_mirrored(recording) if mirrored else recording


def casia_a_recording(
    boxes: pd.DataFrame, directions: pd.Series, *, source: str, problems: Sequence[str] = ()
) -> Recording:
    """A CASIA A recording from a box table and labels of at least its sequences."""
    names = list(boxes[SEQUENCE].unique())
    missing = [name for name in names if name not in directions.index]
    if missing:
        raise DatasetError(
            f"directions.csv lacks a label for {', '.join(missing[:5])}; add the sequence, or "
            "take its silhouettes away."
        )
    return Recording(
        casia.NAME,
        boxes,
        casia.FRAME_RATE,
        casia.FRAME_WIDTH,
        casia.FRAME_HEIGHT,
        # The labels are the whole dataset's; the silhouettes may be some of it.
        directions=directions[names],
        problems=tuple(problems),
        source=source,
    )


def measure_casia_a(
    folder: str | Path, *, min_area: int = MIN_AREA, n_jobs: int = -1, progress: bool = False
) -> Recording:
    """Measure every CASIA A silhouette sequence in a folder."""
    boxes, problems = measure_sequences(
        casia.find_sequences(folder), min_area=min_area, n_jobs=n_jobs, progress=progress
    )
    labels = casia.read_directions(Path(folder) / "directions.csv")
    return casia_a_recording(boxes, labels, source="measured", problems=problems)


def read_casia_a(folder: str | os.PathLike) -> Recording:
    """The recording whose box table and labels lie in `folder`.

    Parameters
    ----------
    folder : path-like
        Holds ``boxes.csv.gz`` (or ``boxes.csv``) and ``directions.csv``.

    Raises
    ------
    McnError
        When a file is missing or not such a table.
    """
    folder = Path(folder)
    path = folder / "boxes.csv.gz"
    if not path.is_file() and path.with_suffix("").is_file():
        path = path.with_suffix("")
    boxes = read_table(path, dtype={SEQUENCE: str, SUBJECT: str})
    check_boxes(boxes, argument=f"{folder.name}/{path.name}")
    labels = casia.read_directions(folder / "directions.csv")
    return casia_a_recording(boxes, labels, source="bundled")


def example_masks(direction: int, *, seed: int = 0) -> np.ndarray:
    """The silhouettes of one walk: a real one, or without images a synthetic one.

    Parameters
    ----------
    direction : int
        1 … 8.  A direction that nobody walks is mirrored from one that somebody does.
    seed : int, optional
        Of the synthetic walker and of the noise of his segmentation.

    Returns
    -------
    ndarray, shape (frames, 240, 352), uint8
    """
    folder = casia_a_folder()
    if folder is None:
        walk = make_walks(subjects=1, seed=seed, directions=(direction,))[0]
        return add_noise(walk.masks, EXAMPLE_NOISE, seed=seed)
    labels = casia.read_directions(folder / "directions.csv")
    sequences = {sequence.name: sequence for sequence in casia.find_sequences(folder)}
    for wanted, prepare in ((direction, np.asarray), (mirror_direction(direction), mirror_masks)):
        for name in labels.index[labels == wanted]:
            if name in sequences:
                return prepare(sequences[name].read())
    raise DatasetError(f"direction is {direction}: nobody in {folder} walks so; pass another.")


def flow_sequences() -> dict[str, tuple]:
    """Pairs of frames with true flow: Middlebury's, or made ones without them.

    Returns
    -------
    dict
        Name in lower case → (first, second, truth).
    """
    folder = dataset_folder(middlebury.NAME)
    if folder is None:
        return {name: make_motion(name)[1:] for name in MOTIONS}
    return {found.name.lower(): found.read() for found in middlebury.find_sequences(folder)}


def pets2009_traces(
    finders: Sequence[str] = tuple(PETS_FINDERS),
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Where people of PETS 2009 stood, as our own chain saw it, and how well that agrees.

    Parameters
    ----------
    finders : sequence of str, optional
        Which of `PETS_FINDERS`.

    Returns
    -------
    points : pandas.DataFrame
        One row a trace point: ``method`` (one of `PETS_FINDERS`), ``trace, frame, x, y``
        (metres), ``matched`` (whether somebody's true feet are within a metre),
        ``error`` (metres; 1 where nobody's are) and ``person`` (whose; 0 for nobody).
    feet : pandas.DataFrame
        One row a person and frame: ``method, trace`` (the person), ``frame, found, error``.

    Raises
    ------
    McnError
        When files are missing or damaged.
    """
    for finder in finders:
        require_choice("finders", finder, tuple(PETS_FINDERS))
    points, feet = TRACES.tables(finders=finders)
    return points[points["method"].isin(finders)], feet[feet["method"].isin(finders)]


def measure_pets2009_traces(
    folder: str | Path, *, finders: Sequence[str] = tuple(PETS_FINDERS)
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Trace the people of PETS 2009 in the video in `folder`, and score the traces."""
    from joblib import Parallel, delayed

    truth = true_pets_feet(folder)
    found = Parallel(n_jobs=2)(
        delayed(trace_pets)(folder, PETS_FINDERS[finder]) for finder in finders
    )
    points, feet = [], []
    for method, table in zip(finders, found, strict=True):
        score = traces.score_traces(table, truth)
        person = pd.to_numeric(score.points["whose"].replace("", "0")).astype(int)
        points.append(score.points.assign(method=method, person=person))
        feet.append(score.feet.assign(method=method))
    points = pd.concat(points, ignore_index=True)
    feet = pd.concat(feet, ignore_index=True)
    # The true feet themselves are others' work and stay where they are.
    return (
        points[["method", TRACE, FRAME, X, Y, "matched", "error", "person"]].round(4),
        feet[["method", TRACE, FRAME, "found", "error"]].round(4),
    )


TRACES = Kept(
    pets.PETS, ("traces", "feet"), pets_video_files, measure_pets2009_traces, text=(TRACE,)
)


def trace_pets(folder: str | os.PathLike, method: str) -> pd.DataFrame:
    """The traces of PETS 2009, View 1, by one of `traces.METHODS`: metres, frames from 0."""
    path, calibration, _ = pets_video_files(folder)
    video = open_video(path, frame_rate=pets.PETS_FRAME_RATE)
    camera = pets.read_tsai(calibration, frame_width=video.width)
    return traces.trace_video(video, camera.to_ground, method=method, height=camera.height_at)


def true_pets_feet(folder: str | os.PathLike) -> pd.DataFrame:
    """The true feet of PETS 2009, View 1: a trace table, metres, frames from 0."""
    world = motchallenge.read_mot_world(pets_video_files(folder)[2])
    names = {SEQUENCE: TRACE, WORLD_X: X, WORLD_Y: Y}
    return world.rename(columns=names).sort_values([TRACE, FRAME], ignore_index=True)


def pets2009_scene() -> Scene:
    """PETS 2009 as a scene: our traces by background subtraction.

    A trace that passes from one person to another is cut there, and every piece knows whose
    it is, so that a split by people puts nobody in both halves.

    Examples
    --------
    >>> scene = pets2009_scene()
    >>> scene.name, scene.frame_rate
    ('pets', 7.0)
    """
    table = pets2009_traces(["background"])[0].reset_index(drop=True)
    # Between two sightings of a person the trace is taken to be his.
    person = table["person"].where(table["person"] > 0)
    person = person.groupby(table[TRACE]).transform(lambda held: held.ffill().bfill())
    person = person.fillna(0).astype(int).astype(str)
    began = (table[TRACE] != table[TRACE].shift()) | (person != person.shift())
    piece = table[TRACE] + "." + began.groupby(table[TRACE]).cumsum().astype(str)
    # Nobody's traces are strangers', each his own.
    people = {name: who for name, who in zip(piece, person, strict=True) if who != "0"}
    table = table.assign(**{TRACE: piece})[[TRACE, FRAME, X, Y]]
    return Scene(
        "pets",
        table,
        pets.PETS_FRAME_RATE,
        area_of(table, margin=1.0),
        people=people,
        source="measured",
    )


def scenes() -> list[Scene]:
    """Every place at hand where people walk: the made corridor, PETS, and real trajectories.

    Returns
    -------
    list of Scene
        The corridor first.  Trajectories only with ``MCNLAB_DATA``.

    Raises
    ------
    McnError
        When files are damaged beyond leaving a trace out.

    Examples
    --------
    >>> [scene.name for scene in scenes()][:2]
    ['corridor', 'pets']
    """
    found = [corridor.make_corridor(), pets2009_scene()]
    folder = data_folder()
    if folder is not None:
        found += trajectories.read_scenes(folder)[0]
    return found


def silhouettes_of(recording: Recording, sequence: str, frames: ArrayLike) -> np.ndarray | None:
    """The silhouettes of a walk in some of its frames, where there are any.

    Parameters
    ----------
    recording : Recording
        CASIA A, whose images lie under ``MCNLAB_DATA`` or nowhere, or the made street as
        `street.make_street` makes it unless told otherwise.
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
