"""Synthetic crossings: people walking over a square before one camera, as boxes.

The boxes follow from a pinhole camera above level ground and from where everybody walks, so
the truth is known: who is where, in metres, at every frame.  A box swings in width and height
with the steps, and its edges are a little wrong, as boxes are.  People turn slowly as they
walk; with ``turning=0`` they walk straight on.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from mcnlab.cameras.camera import Camera
from mcnlab.checks import require_count, require_number
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.tables import CX, CY, FRAME, SEQUENCE, SUBJECT, H, W, X, Y

NAME = "crossings"
STATURE = (1.72, 0.09)  # metres, mean and standard deviation
PACE = (1.3, 0.2)  # metres a second
STANDING = 0.15  # share of people who stand about
ASPECT = 0.34  # a standing body's width over its height, arms and coat
SWING = 0.12  # by how much of the height the width swings, seen from the side
STEP_RATE = 1.95  # steps a second
BOB = 0.012  # of the stature, up and down with the steps
MOST = 10_000_000  # people times frames; more would not fit into memory
_FAR_OFF = 10_000.0  # metres; nobody is seen from farther


@dataclass(frozen=True)
class Square:
    """A camera above a square.

    Attributes
    ----------
    frame_width, frame_height : int
        Pixels.
    focal_length : float
        Pixels.
    height : float
        Of the camera above the ground, metres.
    tilt : float
        Of the optical axis below the horizontal, degrees.
    near, far : float
        Between which people cross, metres ahead of the camera.

    Raises
    ------
    ArgumentError
        When a number is out of range.
    """

    frame_width: int = 640
    frame_height: int = 480
    focal_length: float = 800.0
    height: float = 3.0
    tilt: float = 9.0
    near: float = 6.0
    far: float = 20.0

    def __post_init__(self) -> None:
        require_count("frame_width", self.frame_width, low=1)
        require_count("frame_height", self.frame_height, low=1)
        require_number("focal_length", self.focal_length, above=0, unit="pixels")
        require_number("height", self.height, above=0, high=_FAR_OFF, unit="metres")
        require_number("tilt", self.tilt, low=-60, high=80, unit="degrees")
        require_number("near", self.near, above=0, unit="metres")
        require_number("far", self.far, above=self.near, high=_FAR_OFF, unit="metres")

    @cached_property
    def camera(self) -> Camera:
        """The camera, above the world's origin."""
        return Camera.from_tilt(
            focal_length=self.focal_length,
            height=self.height,
            tilt=self.tilt,
            frame_width=self.frame_width,
            frame_height=self.frame_height,
        )

    def scaled(self, factor: float) -> "Square":
        """The same camera with images `factor` times as large, to a whole pixel."""
        factor = require_number("factor", factor, above=0, high=1000)
        return replace(
            self,
            frame_width=round(self.frame_width * factor),
            frame_height=round(self.frame_height * factor),
            focal_length=self.focal_length * factor,
        )


def make_crossings(
    *,
    people: int = 40,
    seconds: float = 40.0,
    frame_rate: float = 25.0,
    square: Square | None = None,
    turning: float = 12.0,
    box_noise: float = 0.008,
    seed: int = 0,
) -> Recording:
    """Boxes of people who cross a square.

    Parameters
    ----------
    people : int, optional
        Some stand (`STANDING`), and some never come into view whole.
    seconds : float, optional
        How long the recording is.  Everybody is on the square, ahead of the camera, at a time
        in it drawn at random.
    frame_rate : float, optional
        Frames a second.
    square : Square, optional
        The camera; 3 m up if not given.
    turning : float, optional
        Standard deviation of how far a heading wanders within a second, degrees (a random
        walk); 0 is straight on.
    box_noise : float, optional
        Standard deviation of each edge of a box, as a share of the body's height in the
        image.
    seed : int, optional

    Returns
    -------
    Recording
        One track a person who comes into view, with boxes where the whole body is in the
        frame, and with ``world_x, world_y`` (metres right of and ahead of the camera).  Frames
        count from 1; the centroid is the middle of the box.

    Raises
    ------
    ArgumentError
        When a number is out of range, or there is too much to make.
    DatasetError
        When nobody comes into view.

    Examples
    --------
    >>> made = make_crossings(people=5, seconds=10)
    >>> made.frame_rate, made.frame_width, made.frame_height
    (25.0, 640, 480)
    """
    people = require_count("people", people, low=1)
    seconds = require_number("seconds", seconds, above=0, unit="seconds")
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    turning = require_number("turning", turning, low=0, unit="degrees")
    box_noise = require_number("box_noise", box_noise, low=0, high=0.2)
    square = Square() if square is None else square
    if not isinstance(square, Square):
        raise ArgumentError(f"square is {square!r}; pass a Square, or None for the usual one.")
    if people * max(2.0, seconds * frame_rate) > MOST:
        raise ArgumentError(
            f"people, seconds and frame_rate make {people} × {seconds * frame_rate:g} boxes; "
            f"pass less, {MOST:,} at most."
        )
    rng = np.random.default_rng(require_count("seed", seed))
    frames = max(2, round(seconds * frame_rate))
    time = np.arange(frames) / frame_rate

    stature = rng.normal(*STATURE, (people, 1)).clip(1.4, 2.1)
    pace = np.abs(rng.normal(*PACE, (people, 1)))
    pace[rng.uniform(size=(people, 1)) < STANDING] = 0.0
    begin = rng.uniform(0, 2 * np.pi, (people, 1))
    turns = np.radians(turning) / np.sqrt(frame_rate) * rng.normal(size=(people, frames))
    heading = begin + np.cumsum(turns, axis=1)
    # Everybody is at a place of his own, evenly over the square, at a time of his own.
    ahead0 = np.sqrt(rng.uniform(square.near**2, square.far**2, (people, 1)))
    half_view = 0.45 * square.frame_width / square.focal_length
    right0 = ahead0 * rng.uniform(-half_view, half_view, (people, 1))
    there = rng.integers(frames, size=(people, 1))
    right, ahead = (
        start + way - np.take_along_axis(way, there, axis=1)
        for start, way in (
            (right0, np.cumsum(pace * np.sin(heading), axis=1) / frame_rate),
            (ahead0, np.cumsum(pace * np.cos(heading), axis=1) / frame_rate),
        )
    )
    boxes = _look(square, right, ahead, heading, pace, stature, time, rng, box_noise)
    return Recording(
        NAME, boxes, frame_rate, square.frame_width, square.frame_height, source="synthetic"
    )


def _look(square, right, ahead, heading, pace, stature, time, rng, box_noise):
    """The boxes of everybody who is wholly in view."""
    phase = 2 * np.pi * (STEP_RATE * time + rng.uniform(size=stature.shape))
    moving = pace > 0
    # Steps show across the line of sight.  Once a step the legs are apart, and the head bobs.
    sideways = np.abs(np.sin(heading - np.arctan2(right, ahead)))
    aspect = ASPECT + SWING * moving * sideways * (0.5 + 0.5 * np.cos(phase))
    top = stature * (1 + BOB * moving * np.sin(phase))
    # NaN behind the camera, which lies within no frame.
    (column, feet), (_, head) = (
        np.moveaxis(square.camera.see(np.stack([right, ahead, up], axis=-1))[0], -1, 0)
        for up in (np.zeros_like(top), top)
    )
    height = feet - head
    width = aspect * height
    edges = np.stack([column - width / 2, head, column + width / 2, feet])
    edges = edges + box_noise * height * rng.normal(size=edges.shape)
    left, up, far, down = edges
    seen = (
        (ahead > 0.3 * square.near)
        & (left >= 0)
        & (far <= square.frame_width - 1)
        & (up >= 0)
        & (down <= square.frame_height - 1)
        & (far - left > 1)
        & (down - up > 1)
    )
    if not seen.any():
        raise DatasetError("square shows nobody; move near and far into the camera's view.")
    who, frame = np.nonzero(seen)
    names = np.array([f"p{number:03d}" for number in range(1, len(right) + 1)], dtype=object)
    left, up, far, down = (edge[seen] for edge in edges)
    return pd.DataFrame(
        {
            SEQUENCE: names[who],
            SUBJECT: names[who],
            FRAME: frame + 1,
            X: left,
            Y: up,
            W: far - left,
            H: down - up,
            CX: (left + far) / 2,
            CY: (up + down) / 2,
            "world_x": right[seen],
            "world_y": ahead[seen],
        }
    )
