"""People in public places, boxed by hand or by a detector.

PETS 2009 S2.L1, View 1: J. Ferryman and A. Shahrokni, "PETS2009: Dataset and challenge",
2009.  Boxes by hand in XML, world metres from MOTChallenge's release of the same people
(L. Leal-Taixé et al., "MOTChallenge 2015", arXiv:1504.01942), and the place of the camera
from its Tsai calibration (R. Tsai, IEEE J. Robotics and Automation 3(4), 1987).
"""

import warnings
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pandas as pd

from mcnlab.columns import CX, CY, FRAME, SEQUENCE, SUBJECT, H, W, X, Y, check_columns
from mcnlab.datasets.recording import Recording
from mcnlab.errors import DatasetError
from mcnlab.ground import TsaiCamera, place_of
from mcnlab.lines import fit_lines

PETS = "pets2009"
PETS_WIDTH, PETS_HEIGHT = 768, 576  # pixels of the boxes
PETS_FRAME_RATE = 7.0  # frames a second; the video's container says 10
PETS_FOCAL_LENGTH = 1190.0  # pixels: between the calibration's 1185 across and 1195 down

WORLD_X, WORLD_Y = "world_x", "world_y"  # metres

_EXTRINSIC = ("tx", "ty", "tz", "rx", "ry", "rz")


def read_pets(folder):
    """The boxes of PETS 2009 S2.L1, View 1, as a recording of one camera.

    Parameters
    ----------
    folder : path-like
        Holds ``PETS2009-S2L1.xml``.

    Returns
    -------
    Recording
        A sequence is a person; frames count from 0, as in the XML file.

    Raises
    ------
    DatasetError
        When the file is missing or is not such a file.
    """
    path = Path(folder) / "PETS2009-S2L1.xml"
    try:
        root = ElementTree.parse(path).getroot()
        rows = [
            (
                int(item.attrib["id"]),
                int(frame.attrib["number"]),
                *(float(item.find("box").attrib[key]) for key in ("xc", "yc", "w", "h")),
            )
            for frame in root.iter("frame")
            for item in frame.iter("object")
        ]
    except FileNotFoundError as fault:
        raise DatasetError(f"{path} is missing; put PETS 2009's box file there.") from fault
    except (OSError, ElementTree.ParseError, LookupError, ValueError, AttributeError) as fault:
        raise DatasetError(
            f"{path} is not a PETS box file ({fault}); each frame needs objects with an id and "
            "a box of xc, yc, w and h."
        ) from fault
    if not rows:
        raise DatasetError(f"{path} holds no boxes; restore it from the dataset.")
    table = pd.DataFrame(rows, columns=[SUBJECT, FRAME, CX, CY, W, H])
    table = table.sort_values([SUBJECT, FRAME], ignore_index=True)
    table[X] = table[CX] - table[W] / 2
    table[Y] = table[CY] - table[H] / 2
    table[SUBJECT] = table[SUBJECT].astype(str)
    table[SEQUENCE] = table[SUBJECT]
    boxes = table[[SEQUENCE, SUBJECT, FRAME, X, Y, W, H, CX, CY]]
    return Recording(PETS, boxes, PETS_FRAME_RATE, PETS_WIDTH, PETS_HEIGHT)


def read_mot_world(path):
    """World positions of a MOTChallenge ground-truth file that ends in metres (MOT15).

    Parameters
    ----------
    path : path-like
        ``frame, id, left, top, width, height, conf, X, Y, Z`` a line, frames from 1.

    Returns
    -------
    pandas.DataFrame
        ``sequence, frame, world_x, world_y``; frames from 0.

    Raises
    ------
    DatasetError
        When the file is missing, a line is not such a line, or a number is not finite.
    """
    path = Path(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # an empty file is refused below
            values = np.loadtxt(path, delimiter=",", ndmin=2)
    except FileNotFoundError as fault:
        raise DatasetError(f"{path} is missing; put the ground truth there.") from fault
    except (OSError, ValueError) as fault:
        raise DatasetError(f"{path} is not a table of numbers: {fault}; restore it.") from fault
    if values.shape[1] < 9 or len(values) == 0 or not (np.abs(values) < 1e9).all():
        raise DatasetError(
            f"{path} has {values.shape[1]} columns in {len(values)} rows; world positions need "
            "the ten finite columns of MOT15: frame, id, box, conf, X, Y, Z."
        )
    who = values[:, :2]
    if (who != np.round(who)).any() or len(np.unique(who, axis=0)) != len(who):
        raise DatasetError(
            f"{path} has a frame or id that is not whole, or a person twice in a frame; mend it."
        )
    return pd.DataFrame(
        {
            SEQUENCE: values[:, 1].astype(int).astype(str),
            FRAME: values[:, 0].astype(int) - 1,
            WORLD_X: values[:, 7],
            WORLD_Y: values[:, 8],
        }
    )


def read_tsai(path):
    """A camera with a Tsai calibration.

    Parameters
    ----------
    path : path-like
        An XML file with ``Geometry`` dpx, dpy (mm), ``Intrinsic`` focal (mm), kappa1 (1/mm²),
        cx, cy (pixels), sx, and ``Extrinsic`` tx, ty, tz (mm), rx, ry, rz (radians).

    Returns
    -------
    TsaiCamera
        For the image that it was calibrated on, 768×576 in PETS 2009.

    Raises
    ------
    DatasetError
        When the file is missing, lacks a number, or holds an impossible one.
    """
    held = _read_numbers(
        path,
        Geometry=("dpx", "dpy"),
        Intrinsic=("focal", "kappa1", "cx", "cy", "sx"),
        Extrinsic=_EXTRINSIC,
    )
    if min(held[name] for name in ("dpx", "dpy", "focal", "sx")) <= 0:
        raise DatasetError(
            f"{path} is not a Tsai calibration (dpx, dpy, focal and sx must be positive); "
            "restore it."
        )
    turn, shift = _pose(held)
    return TsaiCamera(
        focal=held["focal"],
        kappa=held["kappa1"],
        centre=(held["cx"], held["cy"]),
        aspect=held["sx"],
        pitch=(held["dpx"], held["dpy"]),
        turn=turn,
        shift=shift,
    )


def read_tsai_place(path):
    """Where on the ground a camera with a Tsai calibration stands.

    Parameters
    ----------
    path : path-like
        An XML file with ``Extrinsic`` tx, ty, tz (mm), rx, ry, rz (radians).

    Returns
    -------
    ndarray, shape (3,)
        World metres.

    Raises
    ------
    DatasetError
        When the file is missing or lacks a number.
    """
    turn, shift = _pose(_read_numbers(path, Extrinsic=_EXTRINSIC))
    return place_of(turn, shift)


def _read_numbers(path, **wanted):
    """Attributes of a calibration's elements, as finite floats."""
    path = Path(path)
    held = {}
    try:
        root = ElementTree.parse(path).getroot()
        for element, names in wanted.items():
            attributes = root.find(element).attrib
            held |= {name: float(attributes[name]) for name in names}
        if not np.isfinite(list(held.values())).all():
            raise ValueError("a number is not finite")
    except FileNotFoundError as fault:
        raise DatasetError(f"{path} is missing; put the camera's calibration there.") from fault
    except (OSError, ElementTree.ParseError, AttributeError, LookupError, ValueError) as fault:
        needs = "; ".join(f"{element} {', '.join(names)}" for element, names in wanted.items())
        raise DatasetError(
            f"{path} is not a Tsai calibration ({fault}); it needs {needs}."
        ) from fault
    return held


def _pose(held):
    """World to camera, Rz·Ry·Rx, and the shift in millimetres."""
    turn = np.array([held[key] for key in ("rx", "ry", "rz")])
    (cos_x, cos_y, cos_z), (sin_x, sin_y, sin_z) = np.cos(turn), np.sin(turn)
    about_x = np.array([[1, 0, 0], [0, cos_x, -sin_x], [0, sin_x, cos_x]])
    about_y = np.array([[cos_y, 0, sin_y], [0, 1, 0], [-sin_y, 0, cos_y]])
    about_z = np.array([[cos_z, -sin_z, 0], [sin_z, cos_z, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x, np.array([held[key] for key in ("tx", "ty", "tz")])


def true_motion(world, windows, *, window, frame_rate):
    """Where each window's walker is and how he moves, by least-squares lines.

    Parameters
    ----------
    world : pandas.DataFrame
        ``sequence, frame, world_x, world_y`` (metres).
    windows : pandas.DataFrame
        ``sequence, frame``: whose, and from which frame on.
    window : int
        Frames a window.
    frame_rate : float
        Frames a second.

    Returns
    -------
    place, velocity : ndarray, shape (n, 2)
        Metres and metres a second; not a number where a window has fewer than two
        positions.

    Raises
    ------
    McnError
        When a column is missing, or a person is twice in a frame.
    """
    check_columns(world, (SEQUENCE, FRAME, WORLD_X, WORLD_Y), argument="world")
    check_columns(windows, (SEQUENCE, FRAME), argument="windows")
    if world.duplicated([SEQUENCE, FRAME]).any():
        raise DatasetError("world has a person twice in one frame; drop the duplicates.")
    frames = windows[FRAME].to_numpy()[:, None] + np.arange(window)
    names = np.repeat(windows[SEQUENCE].to_numpy(), window)
    index = pd.MultiIndex.from_arrays([names, frames.ravel()])
    held = world.set_index([SEQUENCE, FRAME])[[WORLD_X, WORLD_Y]].reindex(index).to_numpy()
    held = held.reshape(len(windows), window, 2)
    there = np.isfinite(held).all(axis=2)
    known = there.sum(axis=1) >= 2
    place, velocity = np.full((2, len(windows), 2), np.nan)
    if known.any():
        held, weights = held[known], there[known].astype(float)
        held = np.where(weights[..., None] > 0, held, 0.0)
        time = np.arange(window) / frame_rate
        place[known] = held.sum(axis=1) / weights.sum(axis=1)[:, None]
        for axis in (0, 1):
            velocity[known, axis] = fit_lines(time, held[..., axis], weights=weights).slope
    return place, velocity


def true_headings(world, windows, *, place, window, frame_rate):
    """The true heading against the line of sight, and the true speed, in each window.

    Parameters
    ----------
    world : pandas.DataFrame
        ``sequence, frame, world_x, world_y`` (metres).
    windows : pandas.DataFrame
        ``sequence, frame``: whose, and from which frame on.
    place : array_like, shape (2,) or (3,)
        Where the camera stands, metres.
    window : int
        Frames a window.
    frame_rate : float
        Frames a second.

    Returns
    -------
    pandas.DataFrame
        Indexed like `windows`: ``true_sight`` (degrees, clockwise from straight away)
        and ``true_speed`` (m/s), by least-squares lines through the positions.

    Raises
    ------
    DatasetError
        When a window has fewer than two positions.
    """
    middle, velocity = true_motion(world, windows, window=window, frame_rate=frame_rate)
    unknown = np.isnan(middle).any(axis=1)
    if unknown.any():
        name = windows[SEQUENCE].iloc[int(np.argmax(unknown))]
        raise DatasetError(
            f"world has no two positions of {name!r} in one of its windows; "
            "pass windows of people whose positions are known."
        )
    middle, (vx, vy) = middle - np.asarray(place)[:2], velocity.T
    # World angles turn counter-clockwise, headings clockwise.
    turn = np.arctan2(middle[:, 1], middle[:, 0]) - np.arctan2(vy, vx)
    return pd.DataFrame(
        {"true_sight": np.degrees(turn) % 360, "true_speed": np.hypot(vx, vy)},
        index=windows.index,
    )
