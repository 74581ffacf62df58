"""Mirror images: how the thesis makes eight directions out of six (section 3.1).

A walk seen in a vertical mirror is a walk in the mirrored direction: away-right (2)
becomes away-left (8), toward-left (6) becomes toward-right (4).  The images and the box
tables are mirrored by separate code, and a test holds the two against each other.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab import tables
from mcnlab.checks import require_count
from mcnlab.compass import direction_of, heading_of
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.tables import CX, SEQUENCE, W, X

SUFFIX = "-mirror"
OBLIQUE = (2, 4, 6, 8)


def mirror_direction(direction: ArrayLike) -> int | np.ndarray:
    """The direction 1 … 8 of a walk seen in a vertical mirror: left and right swap.

    Parameters
    ----------
    direction : int or array_like of int

    Raises
    ------
    ArgumentError
        When a direction is not 1 … 8.
    """
    mirrored = direction_of(-heading_of(direction))
    return int(mirrored) if mirrored.ndim == 0 else mirrored


def mirror_masks(masks: ArrayLike) -> np.ndarray:
    """Masks (…, height, width) with left and right swapped, as a contiguous copy."""
    masks = np.asarray(masks)
    if masks.ndim < 2:
        raise ArgumentError(f"masks has shape {masks.shape}; pass images (…, height, width).")
    return np.ascontiguousarray(masks[..., ::-1])


def mirror_boxes(boxes: pd.DataFrame, *, frame_width: int) -> pd.DataFrame:
    """The box table of the mirrored images.

    Parameters
    ----------
    boxes : pandas.DataFrame
        A box table, pixels.
    frame_width : int
        Pixels.

    Returns
    -------
    pandas.DataFrame
        A copy with ``x`` and ``cx`` mirrored; names stay.

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound or the width is not a positive whole number.
    """
    tables.check_boxes(boxes)
    frame_width = require_count("frame_width", frame_width, low=1)
    return boxes.assign(**{X: frame_width - boxes[X] - boxes[W], CX: (frame_width - 1) - boxes[CX]})


def add_mirrored(recording: Recording, *, directions: Sequence[int] = OBLIQUE) -> Recording:
    """The recording with a mirror image of every walk in `directions` added.

    CASIA Dataset A has two walks a subject in directions 1, 2, 3, 5, 6 and 7; mirroring
    the oblique ones gives two in each of the eight: 16 videos a subject (section 3.1).

    Raises
    ------
    DatasetError
        When the recording has no direction labels or holds mirrored walks already.
    """
    if recording.directions is None:
        raise DatasetError(f"{recording.name} has no direction labels; pass a labelled recording.")
    if recording.copies:
        raise DatasetError(f"{recording.name} holds mirrored walks already; mirror it once only.")
    if not all(isinstance(name, str) for name in recording.sequences):
        raise DatasetError(f"{recording.name} has sequences that are not named by text; name them.")
    labels = recording.directions
    chosen = labels.index[labels.isin(directions)]
    rows = recording.boxes[recording.boxes[SEQUENCE].isin(chosen)]
    if rows.empty:
        return recording
    twins = mirror_boxes(rows, frame_width=recording.frame_width)
    twins[SEQUENCE] += SUFFIX
    twin_labels = pd.Series(
        mirror_direction(labels[chosen].to_numpy()), index=chosen + SUFFIX, name=labels.name
    )
    return recording.with_boxes(
        pd.concat([recording.boxes, twins], ignore_index=True),
        directions=pd.concat([labels, twin_labels]),
        copies=frozenset(twin_labels.index),
    )
