"""The data that every notebook starts from: measured anew, or what came with mcnlab.

With the environment variable ``MCNLAB_DATA`` naming a folder of recordings, whatever lies
there is measured in full.  Without it, the tables in ``data/`` stand in: measurements that
this package made of the same recordings (``python -m mcnlab measure``), whose images are
not ours to hand on.
"""

import os
import zlib
from pathlib import Path

import numpy as np
import pandas as pd

from mcnlab import columns, traces
from mcnlab.columns import FRAME, SEQUENCE, TRACE, X, Y
from mcnlab.comparison import compare_sequences
from mcnlab.datasets import casia, corridor, middlebury, motchallenge, pedestrians, trajectories
from mcnlab.datasets.mirror import add_mirrored, mirror_direction, mirror_masks
from mcnlab.datasets.motions import MOTIONS, make_motion
from mcnlab.datasets.noise import SegmentationNoise, add_noise
from mcnlab.datasets.recording import Recording
from mcnlab.datasets.scene import Scene, area_of
from mcnlab.datasets.video import open_video
from mcnlab.datasets.walkers import make_walks
from mcnlab.direction import turn_between
from mcnlab.errors import DatasetError, require_choice
from mcnlab.pace import compare_speeds, find_place
from mcnlab.perspective import measure_headings
from mcnlab.silhouettes import MIN_AREA, measure_sequences

BUNDLED = Path(__file__).resolve().parent.parent / "data"
VARIABLE = "MCNLAB_DATA"
PETS_WINDOW = 7  # frames, one second
TUD = "tud-stadtmitte"
MOTCHALLENGE = "motchallenge"
# Pixels, 1.2 frame widths: nothing is published.  Sideways speed does not need it.
TUD_FOCAL_LENGTH = 768.0
SPEED_SECONDS = (0.5, 1.0, 2.0)  # windows of the speed tables
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


def data_folder():
    """The folder that ``MCNLAB_DATA`` names, or None.

    Raises
    ------
    DatasetError
        When the variable names something that is not a folder.
    """
    value = os.environ.get(VARIABLE)
    if not value:
        return None
    folder = Path(value).expanduser()
    if not folder.is_dir():
        raise DatasetError(
            f"{VARIABLE} is {value!r}, which is not a folder; name one laid out as the README "
            "says, or unset it."
        )
    return folder


def casia_a_folder():
    """The folder of CASIA A silhouettes under ``MCNLAB_DATA``, or None."""
    folder = data_folder()
    if folder is None or not (folder / casia.NAME / "silhouettes").is_dir():
        return None
    return folder / casia.NAME


def casia_a(*, mirrored=True, progress=False):
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
    """
    folder = casia_a_folder()
    if folder is None:
        recording = read_casia_a(BUNDLED / casia.NAME)
    else:
        recording = measure_casia_a(folder, progress=progress)
    return add_mirrored(recording) if mirrored else recording


def casia_a_recording(boxes, directions, *, source, problems=()):
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


def measure_casia_a(folder, *, min_area=MIN_AREA, n_jobs=-1, progress=False):
    """Measure every CASIA A silhouette sequence in a folder."""
    boxes, problems = measure_sequences(
        casia.find_sequences(folder), min_area=min_area, n_jobs=n_jobs, progress=progress
    )
    labels = casia.read_directions(Path(folder) / "directions.csv")
    return casia_a_recording(boxes, labels, source="measured", problems=problems)


def read_casia_a(folder):
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
    boxes = read_table(path, dtype={SEQUENCE: str, columns.SUBJECT: str})
    columns.check_boxes(boxes, argument=f"{folder.name}/{path.name}")
    labels = casia.read_directions(folder / "directions.csv")
    return casia_a_recording(boxes, labels, source="bundled")


def example_masks(direction, *, seed=0):
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


def pets2009_headings():
    """Headings of the people of PETS 2009, from boxes and from world truth.

    Returns
    -------
    pandas.DataFrame
        One row a one-second window (`perspective.measure_headings`) with ``true_sight``
        (degrees), ``true_speed`` (m/s) and ``error`` (degrees).

    Raises
    ------
    DatasetError
        When files are missing or damaged.
    """
    folder = data_folder()
    if folder is None or not all(path.is_file() for path in pets_files(folder)):
        return read_table(BUNDLED / pedestrians.PETS / "headings.csv.gz", dtype={SEQUENCE: str})
    return measure_pets2009(folder)


def measure_pets2009(folder):
    """Measure the headings of PETS 2009 from the recordings in `folder`."""
    boxes, calibration, positions = pets_files(folder)
    recording = pedestrians.read_pets(boxes.parent)
    place = pedestrians.read_tsai_place(calibration)
    world = pedestrians.read_mot_world(positions)
    headings = measure_headings(
        recording,
        focal_length=pedestrians.PETS_FOCAL_LENGTH,
        window=PETS_WINDOW,
        shared="recording",
    )
    truth = pedestrians.true_headings(
        world, headings, place=place, window=PETS_WINDOW, frame_rate=recording.frame_rate
    )
    table = headings.join(truth)
    table["error"] = turn_between(table["sight"], table["true_sight"])
    # Rounded as they are kept, so that the bundled table and a new measurement agree.
    return table.round(dict.fromkeys(table.select_dtypes(float).columns, 4))


def apparent_speeds(name):
    """Apparent, relative and true speed of real people, window by window.

    Parameters
    ----------
    name : {"pets", "tud"}
        PETS 2009 S2.L1, View 1, or TUD-Stadtmitte.

    Returns
    -------
    pandas.DataFrame
        As of `pace.compare_speeds`, for windows of `SPEED_SECONDS`.

    Raises
    ------
    McnError
        When there is no such name, or files are missing or damaged.
    """
    require_choice("name", name, ("pets", "tud"))
    held, files, measure = {
        "pets": (pedestrians.PETS, pets_files, measure_pets2009_speeds),
        "tud": (TUD, tud_files, measure_tud_speeds),
    }[name]
    folder = data_folder()
    if folder is None or not all(path.is_file() for path in files(folder)):
        return read_table(BUNDLED / held / "speeds.csv.gz", dtype={SEQUENCE: str})
    return measure(folder)


def measure_pets2009_speeds(folder):
    """Measure the speeds of PETS 2009 from the recordings in `folder`."""
    boxes, calibration, positions = pets_files(folder)
    table = compare_speeds(
        pedestrians.read_pets(boxes.parent),
        pedestrians.read_mot_world(positions),
        place=pedestrians.read_tsai_place(calibration),
        focal_length=pedestrians.PETS_FOCAL_LENGTH,
        seconds=SPEED_SECONDS,
    )
    return _as_kept(table)


def measure_tud_speeds(folder):
    """Measure the speeds of TUD-Stadtmitte from the recordings in `folder`."""
    positions = tud_files(folder)[0]
    recording = motchallenge.read_sequence(positions.parents[1])
    world = pedestrians.read_mot_world(positions)
    world[FRAME] += 1  # boxes count from 1, as their file does
    table = compare_speeds(
        recording,
        world,
        place=find_place(recording, world),
        focal_length=TUD_FOCAL_LENGTH,
        seconds=SPEED_SECONDS,
    )
    return _as_kept(table)


def _as_kept(table):
    """Speeds rounded as they are kept, so that the bundled table and a new one agree."""
    places = dict.fromkeys(table.select_dtypes(float).columns, 4)
    return table.round(places | {"share": 6})


def video_pairs():
    """Pairs of people in videos, and what forecasters said of them.

    Returns
    -------
    tables : list of pandas.DataFrame
        One a recording, as `comparison.compare` gives them: every MOTChallenge sequence
        under ``MCNLAB_DATA``, or those that came with mcnlab.
    problems : tuple of str
        What was left out, one sentence each.

    Raises
    ------
    McnError
        When files are damaged beyond leaving a sequence out.
    """
    folder = data_folder()
    if folder is None or not (folder / MOTCHALLENGE).is_dir():
        return bundled_pairs(), ()
    tables, problems = compare_sequences(folder / MOTCHALLENGE)
    if tables:
        return tables, problems
    nothing = f"{MOTCHALLENGE} holds no sequence that can be used; the bundled forecasts stand in."
    return bundled_pairs(), (*problems, nothing)


def bundled_pairs():
    """The tables of `video_pairs` that came with mcnlab, one a recording."""
    path = BUNDLED / MOTCHALLENGE / "pairs.csv.gz"
    held = read_table(path, dtype={"first": str, "second": str})
    return [table.reset_index(drop=True) for _, table in held.groupby("recording")]


def flow_sequences():
    """Pairs of frames with true flow: Middlebury's, or made ones without them.

    Returns
    -------
    dict
        Name in lower case → (first, second, truth).
    """
    folder = data_folder()
    if folder is not None and (folder / middlebury.NAME).is_dir():
        found = middlebury.find_sequences(folder / middlebury.NAME)
        return {sequence.name.lower(): sequence.read() for sequence in found}
    return {name: make_motion(name)[1:] for name in MOTIONS}


def pets2009_traces(finders=tuple(PETS_FINDERS)):
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
    folder = data_folder()
    if folder is None or not all(path.is_file() for path in pets_video_files(folder)):
        held = BUNDLED / pedestrians.PETS
        tables = (
            read_table(held / f"{name}.csv.gz", dtype={TRACE: str}) for name in ("traces", "feet")
        )
        return tuple(table[table["method"].isin(finders)] for table in tables)
    return measure_pets2009_traces(folder, finders=finders)


def measure_pets2009_traces(folder, *, finders=tuple(PETS_FINDERS)):
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


def trace_pets(folder, method):
    """The traces of PETS 2009, View 1, by one of `traces.METHODS`: metres, frames from 0."""
    path, calibration, _ = pets_video_files(folder)
    video = open_video(path, frame_rate=pedestrians.PETS_FRAME_RATE)
    camera = pedestrians.read_tsai(calibration).scaled(video.width / pedestrians.PETS_WIDTH)
    return traces.trace_video(video, camera.to_ground, method=method, height=camera.height_at)


def true_pets_feet(folder):
    """The true feet of PETS 2009, View 1: a trace table, metres, frames from 0."""
    world = pedestrians.read_mot_world(pets_video_files(folder)[2])
    names = {SEQUENCE: TRACE, pedestrians.WORLD_X: X, pedestrians.WORLD_Y: Y}
    return world.rename(columns=names).sort_values([TRACE, FRAME], ignore_index=True)


def pets2009_scene():
    """PETS 2009 as a scene: our traces by background subtraction.

    A trace that passes from one person to another is cut there, and every piece knows whose
    it is, so that a split by people puts nobody in both halves.
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
        pedestrians.PETS_FRAME_RATE,
        area_of(table, margin=1.0),
        people=people,
        source="measured",
    )


def scenes():
    """Every place at hand where people walk: the made corridor, PETS, and real trajectories.

    Returns
    -------
    list of Scene
        The corridor first.  Trajectories only with ``MCNLAB_DATA``.

    Raises
    ------
    McnError
        When files are damaged beyond leaving a trace out.
    """
    found = [corridor.make_traces(), pets2009_scene()]
    folder = data_folder()
    if folder is not None:
        found += trajectories.read_scenes(folder)[0]
    return found


def read_table(path, **options):
    """A CSV table, or `DatasetError` naming the file."""
    try:
        return pd.read_csv(path, **options)
    except FileNotFoundError as fault:
        raise DatasetError(
            f"{path} is missing; install mcnlab from its checkout (pip install -e .), which "
            "holds data/."
        ) from fault
    except (OSError, EOFError, ValueError, zlib.error, pd.errors.ParserError) as fault:
        raise DatasetError(f"{path} is not a table ({fault}); restore it.") from fault


def pets_files(folder):
    """Boxes, calibration and world positions of PETS 2009 under a data folder."""
    folder = Path(folder)
    return [
        folder / pedestrians.PETS / "PETS2009-S2L1.xml",
        folder / pedestrians.PETS / "View_001.xml",
        folder / MOTCHALLENGE / "PETS09-S2L1" / "gt" / "gt.txt",
    ]


def tud_files(folder):
    """Boxes with world positions, and the frame, of TUD-Stadtmitte under a data folder."""
    held = Path(folder) / MOTCHALLENGE / "TUD-Stadtmitte"
    return [held / "gt" / "gt.txt", held / "seqinfo.ini"]


def pets_video_files(folder):
    """Video, calibration and world positions of PETS 2009 under a data folder."""
    folder = Path(folder)
    return [folder / pedestrians.PETS / "vtest.mp4", *pets_files(folder)[1:]]
