"""People in public places, boxed by hand or by a detector.

PETS 2009 S2.L1, View 1: J. Ferryman and A. Shahrokni, "PETS2009: Dataset and challenge",
2009.  Boxes by hand in XML, world metres from MOTChallenge's release of the same people
(L. Leal-Taixé et al., "MOTChallenge 2015", arXiv:1504.01942), and the place of the camera
from its Tsai calibration (R. Tsai, IEEE J. Robotics and Automation 3(4), 1987).
"""

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from mcnlab.cameras.camera import Camera
from mcnlab.checks import require_count
from mcnlab.datasets.reading import reading
from mcnlab.datasets.recording import Recording
from mcnlab.errors import DatasetError
from mcnlab.tables import CX, CY, FRAME, SEQUENCE, SUBJECT, H, W, X, Y

PETS = "pets2009"
PETS_WIDTH, PETS_HEIGHT = 768, 576  # pixels of the boxes
PETS_FRAME_RATE = 7.0  # frames a second; the video's container says 10
PETS_FOCAL_LENGTH = 1190.0  # pixels: between the calibration's 1185 across and 1195 down
_EXTRINSIC = ("tx", "ty", "tz", "rx", "ry", "rz")


def read_pets(folder: str | os.PathLike) -> Recording:
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
    remedy = "each frame needs objects with an id and a box of xc, yc, w and h"
    with reading(path, "a PETS box file", remedy):
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


def read_tsai(path: str | os.PathLike, *, frame_width: int = PETS_WIDTH) -> Camera:
    """A camera with a Tsai calibration.

    The principal point is taken as published and scaled with the frame: the half pixel
    between an image's corner and its first pixel's centre is less than it is known to.

    Parameters
    ----------
    path : path-like
        An XML file with ``Geometry`` dpx, dpy (mm), ``Intrinsic`` focal (mm), kappa1 (1/mm²),
        cx, cy (pixels), sx, and ``Extrinsic`` tx, ty, tz (mm), rx, ry, rz (radians).
    frame_width : int, optional
        Of the images, pixels; 768 where they are as large as those it was calibrated on.

    Returns
    -------
    Camera
        With frames in the ratio 4 : 3, as of PETS 2009.

    Raises
    ------
    DatasetError
        When the file is missing, lacks a number, or holds an impossible one.
    """
    frame_width = require_count("frame_width", frame_width, low=1)
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
    scale, focal = frame_width / PETS_WIDTH, held["focal"]
    across, down = held["sx"] * focal / held["dpx"], focal / held["dpy"]
    lens = np.diag([scale * across, scale * down, 1])
    lens[:2, 2] = scale * held["cx"], scale * held["cy"]
    height = max(1, round(scale * PETS_HEIGHT))
    return Camera(lens, turn, shift, frame_width, height, held["kappa1"] * focal**2)


def read_tsai_place(path: str | Path) -> np.ndarray:
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
    return -turn.T @ shift


def _read_numbers(path, **wanted):
    """Attributes of a calibration's elements, as finite floats."""
    path = Path(path)
    held = {}
    needs = "; ".join(f"{element} {', '.join(names)}" for element, names in wanted.items())
    with reading(path, "a Tsai calibration", f"it needs {needs}"):
        root = ElementTree.parse(path).getroot()
        for element, names in wanted.items():
            attributes = root.find(element).attrib
            held |= {name: float(attributes[name]) for name in names}
        if not np.isfinite(list(held.values())).all():
            raise ValueError("a number is not finite")
    return held


def _pose(held):
    """World to camera, Rz·Ry·Rx, and the shift in metres."""
    turn = Rotation.from_euler("xyz", [held[key] for key in ("rx", "ry", "rz")])
    return turn.as_matrix(), np.array([held[key] for key in ("tx", "ty", "tz")]) / 1000.0
