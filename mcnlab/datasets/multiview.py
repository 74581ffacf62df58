"""Cameras of recordings that several of them made together.

Sources
-------
WILDTRACK: T. Chavdarova et al., "WILDTRACK: a multi-camera HD dataset for dense unscripted
pedestrian detection", CVPR 2018.
CAMPUS: Y. Xu et al., "Multi-view people tracking via hierarchical trajectory composition",
CVPR 2016.
CMC: "A Bayesian filter for multi-view 3D multi-object tracking with occlusion handling",
J. Ong et al., IEEE Trans. PAMI 44(5), 2022.
"""

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from mcnlab.cameras.camera import Camera
from mcnlab.datasets.reading import read_numbers, reading
from mcnlab.errors import DatasetError

FULL_HD: Final = (1920, 1080)  # pixels
CMC_FRAME: Final = (1920, 1024)


def read_wildtrack_cameras(folder: str | os.PathLike) -> dict[str, Camera]:
    """The seven cameras of WILDTRACK, for its frames, from which distortion was removed.

    Parameters
    ----------
    folder : path-like
        Holds ``calibrations/intrinsic_zero/intr_*.xml`` and
        ``calibrations/extrinsic/extr_*.xml`` (centimetres).

    Returns
    -------
    dict
        Name, such as "CVLab1", → `Camera`, in the order of the views.

    Raises
    ------
    DatasetError
        When a file is missing or is no such calibration.
    """
    held = Path(folder) / "calibrations"
    cameras = {}
    for path in _files(held / "intrinsic_zero", "intr_*.xml"):
        name = path.stem.removeprefix("intr_")
        with reading(path, "an intrinsic calibration of WILDTRACK"):
            lens = _numbers_at(path, "camera_matrix/data").reshape(3, 3)
        pose = held / "extrinsic" / f"extr_{name}.xml"
        with reading(pose, "an extrinsic calibration of WILDTRACK"):
            turn = Rotation.from_rotvec(_numbers_at(pose, "rvec")).as_matrix()
            cameras[name] = Camera(lens, turn, _numbers_at(pose, "tvec") / 100, *FULL_HD)
    return cameras


def read_campus_cameras(folder: str | os.PathLike) -> dict[str, Camera]:
    """The cameras of a scene of UCLA's CAMPUS.

    Parameters
    ----------
    folder : path-like
        Holds ``cam_param.mat``.

    Returns
    -------
    dict
        Name, such as "view-HC3", → `Camera`.

    Raises
    ------
    DatasetError
        When the file is missing or holds no such cameras.
    """
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    path = Path(folder) / "cam_param.mat"
    cameras = {}
    with reading(path, "a calibration of CAMPUS"):
        try:
            with path.open("rb") as file:
                held = loadmat(file, squeeze_me=True, struct_as_record=False)["cam_param"]
        except MatReadError as fault:
            raise ValueError(str(fault)) from fault
        for one in np.atleast_1d(held):
            # K·R·(X − T); K is stored transposed, the principal point apart from it, and
            # both in types of 16 bits.
            lens = np.array(one.K, float).T
            lens[:2, 2] = one.center
            turn = np.array(one.R, float)
            cameras[str(one.name)] = Camera(lens, turn, -turn @ one.T, *FULL_HD)
    return dict(sorted(cameras.items()))


def read_cmc_cameras(folder: str | os.PathLike) -> dict[str, Camera]:
    """The four cameras of CMC.

    Parameters
    ----------
    folder : path-like
        Holds ``camera-*.txt``: projection matrices, metres to pixels.

    Returns
    -------
    dict
        Name, such as "camera-1", → `Camera`.

    Raises
    ------
    DatasetError
        When there is no such file, or one is no projection matrix.
    """
    cameras = {}
    for path in _files(Path(folder), "camera-*.txt"):
        matrix = read_numbers(path, {4: "a row of a projection matrix"}, sep=r"\s+")
        with reading(path, "a projection matrix"):
            cameras[path.stem] = Camera.from_matrix(matrix, CMC_FRAME)
    return cameras


def _files(folder, pattern):
    """The files of a folder, sorted; at least one."""
    found = sorted(folder.glob(pattern))
    if not found:
        raise DatasetError(f"{folder / pattern} is missing; put the cameras' calibrations there.")
    return found


def _numbers_at(path, element):
    """The numbers that an element of an XML file holds, finite."""
    text = ElementTree.parse(path).getroot().find(element).text
    numbers = np.array(text.split(), float)
    if not np.isfinite(numbers).all():
        raise ValueError(f"{element} holds a number that is not finite")
    return numbers
