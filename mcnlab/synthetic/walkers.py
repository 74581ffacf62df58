"""Synthetic walkers: an articulated body with a normal gait, seen by one pinhole camera.

They stand in for recorded silhouettes wherever the truth must be known: where the walker
was, where it was heading, how fast it went.  The body is a set of tapered capsules
(head, neck, torso, arms, legs, feet).  Published joint angles drive it; the lowest foot
stands on the ground and does not slip, so height, speed and bobbing follow from body and
cadence and are not put in by hand.

World coordinates are metres: x to the right, y along the ground away from the camera,
whose foot point is the origin, and z up.  Headings are degrees clockwise seen from above:
0 = away, 90 = right, 180 = toward, 270 = left.

Sources
-------
Segment lengths: Drillis and Contini (1966), as fractions of stature, after Winter,
*Biomechanics and Motor Control of Human Movement*.
Thigh, knee and ankle: approximate values every tenth of a cycle after the mean curves of
Winter and of Perry and Burnfield, *Gait Analysis: Normal and Pathological Function*, with
a periodic cubic spline between.  Those curves come from different people and know nothing
of these segment lengths, so a least-squares fit has moved them (by 2° on average, at most
6°) until both feet reach the ground in double support, the swinging foot clears it, the
pelvis keeps an even pace and a stride is 0.88 statures, that of brisk walking.  They look
normal; they are no clinical reference.
Arms: one sinusoid a joint, the shoulder's between the extremes of Murray, Sepic and
Barnard (1967), *Physical Therapy* 47, 272–284; the elbow's is set by eye.
Radii are those of a clothed adult, set by eye against recorded silhouettes.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final

import cv2
import numpy as np
import pandas as pd

from mcnlab import tables
from mcnlab.cameras.camera import Camera
from mcnlab.checks import require_choice, require_count, require_number
from mcnlab.compass import DIRECTIONS, direction_of, heading_of
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.body import (
    _CAPSULES,
    _INDEX,
    LIMBS,
    Body,
    _cycle,
    _periodic,
    _pose,
    _radii,
    draw_body,
)

X_M: Final = "x_m"  # pelvis on the ground, metres to the right of the camera
Y_M: Final = "y_m"  # pelvis on the ground, metres ahead of the camera
SPEED: Final = "speed"  # over one stride, metres a second
HEADING: Final = "heading_deg"  # degrees clockwise from "away"
STATURE_PX: Final = "stature_px"  # rows from the ground under the pelvis to a stature above
PHASE: Final = "phase"  # gait phase, 0 … 1 from the right heel's contact
CUT: Final = "cut"  # whether the frame's edge cuts the body
_PACE_PERIOD: Final = 3.0  # seconds, of a wobbling pace
_NEAREST: Final = 0.3  # metres from the lens; nearer, a ball's image is no circle
_ARC_POINTS: Final = 9  # on each of a capsule's two ends; odd, to have one at the very end
_SHIFT: Final = 4  # fractional bits of the polygons' corners
_OUTLINE: Final = 0.5  # pixels that cv2.fillConvexPoly adds all round, as it draws the outline
_MAX_FRAMES: Final = 127  # the longest walk in CASIA A
_MARGIN: Final = 2.0  # pixels that a walk keeps from the frame's edge
_OFFSET: Final = 0.3  # metres by which a walk may pass left or right of the optical axis
# Like the camera of CASIA A.
CASIA_VIEW: Final = Camera.from_tilt(
    focal_length=450.0, height=1.55, tilt=4.0, frame_width=352, frame_height=240
)

# Metres ahead of the camera, (low, high), in mid-walk and at the farthest, as in CASIA A.
_LATERAL: Final = ((4.9, 6.1), (10.0, 10.0))
_OBLIQUE: Final = ((6.4, 7.4), (8.6, 9.9))
_RADIAL: Final = ((6.0, 6.6), (8.2, 9.6))

DISTANCES: Final[Mapping] = MappingProxyType(
    {
        direction: (_RADIAL, _OBLIQUE, _LATERAL, _OBLIQUE)[(direction - 1) % 4]
        for direction in DIRECTIONS
    }
)


@dataclass(frozen=True)
class Walk:
    """A straight walk on the ground.

    Attributes
    ----------
    heading : float
        Degrees clockwise from "away".
    x, y : float
        Where the pelvis is in the first frame: metres to the right of the camera and
        ahead of it.
    n_frames : int
        At least 2.
    frame_rate : float
        Frames a second.
    pace_wobble : float
        Relative amplitude of a slow change of cadence, below 1; 0 keeps an even pace.
    pace_phase : float
        Where in that change, of 3 s, the walk begins, in cycles.
    """

    heading: float
    x: float = 0.0
    y: float = 6.0
    n_frames: int = 80
    frame_rate: float = 25.0
    pace_wobble: float = 0.0
    pace_phase: float = 0.0

    def __post_init__(self) -> None:
        require_number("heading", self.heading, unit="degrees")
        require_number("x", self.x, unit="metres")
        require_number("y", self.y, unit="metres")
        require_count("n_frames", self.n_frames, low=2)
        require_number("frame_rate", self.frame_rate, above=0, unit="frames a second")
        require_number("pace_wobble", self.pace_wobble, low=0, high=0.9)
        require_number("pace_phase", self.pace_phase)

    @property
    def axes(self) -> np.ndarray:
        """Unit vectors (x, y, z) to the walker's right, up and forward, shape (3, 3)."""
        sine, cosine = math.sin(math.radians(self.heading)), math.cos(math.radians(self.heading))
        return np.array([[cosine, -sine, 0.0], [0.0, 0.0, 1.0], [sine, cosine, 0.0]])


@dataclass(frozen=True, eq=False)
class SyntheticWalk:
    """A rendered walk with its truth.

    Attributes
    ----------
    name, subject : str
        The sequence and who walks.
    body, walk, view
        What it was rendered from; `render_walk` with these gives the same masks.
    masks : ndarray of uint8, shape (n, frame_height, frame_width)
        255 on the body, 0 elsewhere.
    truth : pandas.DataFrame
        One row a frame, see `render_walk`.
    """

    name: str
    subject: str
    body: Body
    walk: Walk
    view: Camera
    masks: np.ndarray
    truth: pd.DataFrame

    @property
    def heading(self) -> float:
        """Degrees clockwise from "away"."""
        return self.walk.heading

    @property
    def direction(self) -> int:
        """The nearest of the eight directions, 1 … 8."""
        return int(direction_of(self.walk.heading))


@dataclass(frozen=True, eq=False)
class _Motion:
    """A walk's course: one entry a frame."""

    phase: np.ndarray  # cycles, unwrapped
    speed: np.ndarray  # metres a second, over one stride
    pelvis: np.ndarray  # (n, 3), metres in the world
    joints: np.ndarray  # (n, len(JOINTS), 3), metres in the world


@dataclass(frozen=True, eq=False)
class _Image:
    """Where a walk's joints appear."""

    centres: np.ndarray  # (n, len(JOINTS), 2), pixels
    radii: np.ndarray  # (n, len(JOINTS)), pixels
    too_near: np.ndarray  # (n,), whether some joint is behind the lens or almost
    view: Camera

    @cached_property
    def clearance(self) -> np.ndarray:
        """How far the body is inside the frame, pixels; negative where the edge cuts it."""
        reach = self.radii[..., None]
        limit = np.array([self.view.frame_width, self.view.frame_height]) - 0.5
        low = (self.centres - reach).min(axis=(1, 2)) + 0.5
        high = (limit - self.centres - reach).min(axis=(1, 2))
        return np.where(self.too_near, -np.inf, np.minimum(low, high))


def walk_joints(body: Body, walk: Walk) -> tuple[np.ndarray, np.ndarray]:
    """Where a walker's joints are.

    Parameters
    ----------
    body : Body
    walk : Walk

    Returns
    -------
    joints : ndarray, shape (n_frames, len(JOINTS), 3)
        World coordinates in metres, in the order of `JOINTS`.
    radii : ndarray, shape (len(JOINTS),)
        Metres.
    """
    return _move(body, walk).joints, _radii(body)


def render_walk(
    body: Body,
    walk: Walk,
    view: Camera | None = None,
    *,
    drop_limbs: Iterable[str] = (),
    name: str = "walk",
    subject: str = "walker",
) -> tuple[np.ndarray, pd.DataFrame]:
    """Silhouettes of a walk, and the truth about it.

    Parameters
    ----------
    body : Body
    walk : Walk
    view : Camera, optional
        Default: `CASIA_VIEW`.
    drop_limbs : iterable of str, optional
        Limbs to leave out, from `LIMBS`.
    name, subject : str, optional
        For the table.

    Returns
    -------
    masks : ndarray of uint8, shape (n_frames, frame_height, frame_width)
        255 on the body, 0 elsewhere.
    truth : pandas.DataFrame
        One row a frame.  A box table (`mcnlab.tables`) with area, measured on the mask,
        all 0 where the body is wholly outside the frame; and

        - ``x_m, y_m``: the pelvis on the ground, metres;
        - ``speed``: over one stride, metres a second;
        - ``heading_deg``: degrees clockwise from "away";
        - ``stature_px``: rows from the ground under the pelvis to one stature above it;
        - ``phase``: gait phase, 0 … 1 from the right heel's contact;
        - ``cut``: whether the frame's edge cuts the body.

    Raises
    ------
    ArgumentError
        When the walker comes behind the camera or is never in view, or a limb is unknown.
    """
    view = CASIA_VIEW if view is None else view
    drop_limbs = (drop_limbs,) if isinstance(drop_limbs, str) else tuple(drop_limbs)
    for limb in drop_limbs:
        require_choice("drop_limbs", limb, LIMBS)
    motion = _move(body, walk)
    image = _look(body, motion.joints, view)
    if image.too_near.any():
        raise ArgumentError(
            f"walk {name!r} comes within {_NEAREST} m of the camera's image plane in frame "
            f"{1 + int(image.too_near.argmax())}; start farther ahead, make n_frames smaller "
            "or turn the heading."
        )
    masks = _draw(image, drop_limbs)
    truth = _truth(body, walk, motion, image, masks, name, subject)
    if not truth[tables.AREA].any():
        raise ArgumentError(
            f"walk {name!r} is never in view; start nearer the optical axis, "
            "or pass a view with a shorter focal_length or another tilt."
        )
    return masks, truth


def make_walk(
    body: Body,
    *,
    heading: float,
    view: Camera | None = None,
    distance: float = 6.0,
    offset: float = 0.0,
    n_frames: int | None = None,
    max_frames: int = _MAX_FRAMES,
    farthest: float = 50.0,
    frame_rate: float = 25.0,
    pace_wobble: float = 0.0,
    name: str = "walk",
    subject: str = "walker",
) -> SyntheticWalk:
    """One walk past a given place.

    Parameters
    ----------
    body : Body
    heading : float
        Degrees clockwise from "away".
    view : Camera, optional
        Default: `CASIA_VIEW`.
    distance, offset : float, optional
        The place: metres ahead of the camera and to its right.
    n_frames : int, optional
        The walk passes the place in its middle frame, and the frame's edge may cut the
        body.  Default: as many frames around the place as show the body whole.
    max_frames : int, optional
        At most so many frames when `n_frames` is not given; those nearest the place.
    farthest : float, optional
        When `n_frames` is not given, frames with the walker farther ahead than this
        are left out, metres.
    frame_rate : float, optional
        Frames a second.
    pace_wobble : float, optional
        See `Walk`.
    name, subject : str, optional
        For the table.

    Returns
    -------
    SyntheticWalk

    Raises
    ------
    ArgumentError
        When the body is not wholly in view at the place and `n_frames` is not given.
    """
    view = CASIA_VIEW if view is None else view
    require_number("distance", distance, above=0, unit="metres")
    require_number("offset", offset, unit="metres")
    require_number("farthest", farthest, above=0, unit="metres")
    if n_frames is None:
        # So many frames either side of the place are tried, and cut back to those in view.
        require_count("max_frames", max_frames, low=2)
        course = Walk(heading, 0.0, 0.0, 2 * max_frames - 1, frame_rate, pace_wobble)
        middle = max_frames - 1
    else:
        course = Walk(heading, 0.0, 0.0, n_frames, frame_rate, pace_wobble)
        middle = n_frames // 2
    motion = _move(body, course)
    shift = (offset, distance, 0.0) - motion.pelvis[middle] * (1, 1, 0)
    first, last = 0, course.n_frames - 1
    if n_frames is None:
        image = _look(body, motion.joints + shift, view)
        ahead = motion.pelvis[:, 1] + shift[1]
        first, last = _run_in_view(image, ahead, middle, max_frames, farthest)
    x, y, _ = motion.pelvis[first] + shift
    body = replace(body, phase=float(motion.phase[first] % 1.0))
    walk = replace(
        course,
        x=float(x),
        y=float(y),
        n_frames=last - first + 1,
        pace_phase=(first / frame_rate / _PACE_PERIOD) % 1.0,
    )
    masks, truth = render_walk(body, walk, view, name=name, subject=subject)
    return SyntheticWalk(name, subject, body, walk, view, masks, truth)


def make_walks(
    *,
    subjects: int,
    directions: Iterable[int] = DIRECTIONS,
    seed: int,
    view: Camera | None = None,
    repeats: int = 1,
    distances: Mapping = DISTANCES,
    frame_rate: float = 25.0,
    pace_wobble: float = 0.02,
    spread: float = 0.0,
) -> list[SyntheticWalk]:
    """A data set of walks, each wholly inside the frame.

    Parameters
    ----------
    subjects : int
        How many people.  The first ones are the same whatever the number.
    directions : iterable of int, optional
        Out of 1 … 8, see `compass.heading_of`.
    seed : int
        The same seed gives the same walks.
    view : Camera, optional
        Default: `CASIA_VIEW`.
    repeats : int, optional
        Walks of a person in a direction.
    distances : mapping, optional
        For each direction ``((low, high), (low, high))``, in metres: bounds of the
        distance ahead of the camera in mid-walk, and of the farthest.  Default: as in
        CASIA A; another view calls for others.
    frame_rate : float, optional
        Frames a second.
    pace_wobble : float, optional
        See `Walk`.
    spread : float, optional
        Headings are drawn evenly within so many degrees of their direction's; 22.5
        makes every heading as likely as any other.

    Returns
    -------
    list of SyntheticWalk
        Named ``s01-d3_1``: person, direction, repeat.

    Raises
    ------
    ArgumentError
        When `distances` puts a walker where the frame does not show the whole body.

    Examples
    --------
    >>> walks = make_walks(subjects=1, directions=(3,), seed=1)
    >>> walks[0].name, walks[0].masks.shape[1:]
    ('s01-d3_1', (240, 352))
    """
    require_count("subjects", subjects, low=1)
    require_count("repeats", repeats, low=1)
    require_count("seed", seed)
    require_number("spread", spread, low=0, high=22.5, unit="degrees")
    headings = {direction: float(heading_of(direction)) for direction in directions}
    missing = [direction for direction in headings if direction not in distances]
    if missing:
        raise ArgumentError(
            f"distances lacks direction(s) {', '.join(map(str, missing))}; "
            "give each direction ((low, high), (low, high)) in metres."
        )
    walks = []
    for number in range(1, subjects + 1):
        person = draw_body(np.random.default_rng([seed, number]))
        for direction, heading in headings.items():
            middle, farthest = distances[direction]
            for repeat in range(1, repeats + 1):
                # Seeded by what it is, a walk is the same whichever others are asked for.
                rng = np.random.default_rng([seed, number, direction, repeat])
                day = replace(
                    person,
                    phase=float(rng.uniform()),
                    cadence=person.cadence * _near_one(rng),
                    stride=person.stride * _near_one(rng),
                )
                place = {
                    "distance": float(rng.uniform(*middle)),
                    "offset": float(rng.uniform(-_OFFSET, _OFFSET)),
                    "farthest": float(rng.uniform(*farthest)),
                }
                walk = make_walk(
                    day,
                    heading=heading + float(rng.uniform(-spread, spread)),
                    view=view,
                    **place,
                    frame_rate=frame_rate,
                    pace_wobble=pace_wobble,
                    name=f"s{number:02d}-d{direction}_{repeat}",
                    subject=f"s{number:02d}",
                )
                walks.append(walk)
    return walks


def _near_one(rng):
    """A factor for what differs between two walks of one person."""
    return float(np.clip(rng.normal(1.0, 0.02), 0.95, 1.05))


def _move(body, walk):
    """The course of a walk, see `_Motion`."""
    height, lead, length = _cycle(body.stride)
    time = np.arange(walk.n_frames) / walk.frame_rate
    wobble = 2 * math.pi * (walk.pace_phase + time / _PACE_PERIOD)
    late = walk.pace_wobble * _PACE_PERIOD / (2 * math.pi) * (np.cos(wobble[0]) - np.cos(wobble))
    phase = body.phase + body.cadence / 2 * (time + late)
    ahead = length * (phase - phase[0]) + _periodic(phase, lead) - _periodic(phase[:1], lead)
    axes = walk.axes
    pelvis = body.stature * ahead[:, None] * axes[2]
    pelvis[:, 2] = body.stature * _periodic(phase, height)
    pelvis += (walk.x, walk.y, 0.0)
    joints = pelvis[:, None] + body.stature * _pose(body, phase) @ axes
    speed = body.speed * (1 + walk.pace_wobble * np.sin(wobble))
    return _Motion(phase, speed, pelvis, joints)


def _look(body, joints, view):
    """Where joints in the world appear, see `_Image`."""
    depth = view.depth(joints)
    radii = view.focal_length * _radii(body) / np.maximum(depth, _NEAREST)
    return _Image(view.see(joints)[0], radii, (depth < _NEAREST).any(axis=1), view)


def _run_in_view(image, ahead, middle, count, farthest):
    """First and last frame of the run round `middle` that shows the body whole."""
    good = (image.clearance >= _MARGIN) & (ahead <= farthest)
    bad = np.flatnonzero(~good)
    low = int(bad[bad < middle].max(initial=-1)) + 1
    high = int(bad[bad > middle].min(initial=len(good))) - 1
    if not good[middle] or high - low < 1:
        raise ArgumentError(
            "distance and offset put the walker where the frame does not show the whole body, "
            "or beyond farthest; choose another place, or give n_frames to allow cut bodies."
        )
    first = min(max(middle - count // 2, low), max(high - count + 1, low))
    return first, min(first + count - 1, high)


def _draw(image, drop_limbs):
    """The silhouettes, uint8, shape (n, frame_height, frame_width)."""
    kept = [entry for entry in _CAPSULES if entry[0] not in drop_limbs]
    view = image.view
    masks = np.zeros((len(image.centres), view.frame_height, view.frame_width), np.uint8)
    if not kept:
        return masks
    start = [_INDEX[entry[1]] for entry in kept]
    stop = [_INDEX[entry[2]] for entry in kept]
    radii = np.maximum(image.radii - _OUTLINE, 0.0)
    corners = _outlines(
        image.centres[:, start], radii[:, start], image.centres[:, stop], radii[:, stop]
    )
    corners = np.rint(corners * 2**_SHIFT).astype(np.int32)
    for mask, capsules in zip(masks, corners, strict=True):
        for capsule in capsules:
            cv2.fillConvexPoly(mask, capsule, 255, cv2.LINE_8, _SHIFT)
    return masks


def _outlines(start, start_radius, stop, stop_radius):
    """Convex hulls of pairs of circles, as polygons.

    Parameters
    ----------
    start, stop : ndarray, shape (..., 2)
        Centres.
    start_radius, stop_radius : ndarray, shape (...)

    Returns
    -------
    ndarray, shape (..., 2 · _ARC_POINTS, 2)
    """
    between = stop - start
    gap = np.hypot(between[..., 0], between[..., 1])
    bearing = np.arctan2(between[..., 1], between[..., 0])
    # Both common tangents touch at this angle from the line of centres.  Where one circle
    # holds the other the ratio leaves ±1, and the clip leaves the larger circle alone.
    ratio = (start_radius - stop_radius) / np.maximum(gap, 1e-9)
    tangent = np.arccos(np.clip(ratio, -1.0, 1.0))
    along = np.linspace(0.0, 1.0, _ARC_POINTS)
    near = (bearing + tangent)[..., None] + (2 * (np.pi - tangent))[..., None] * along
    far = (bearing - tangent)[..., None] + (2 * tangent)[..., None] * along
    corners = np.empty((*gap.shape, 2 * _ARC_POINTS, 2))
    for part, angle, centre, radius in (
        (slice(None, _ARC_POINTS), near, start, start_radius),
        (slice(_ARC_POINTS, None), far, stop, stop_radius),
    ):
        corners[..., part, 0] = centre[..., :1] + radius[..., None] * np.cos(angle)
        corners[..., part, 1] = centre[..., 1:] + radius[..., None] * np.sin(angle)
    return corners


def _truth(body, walk, motion, image, masks, name, subject):
    """The table that `render_walk` describes."""
    ground = motion.pelvis * (1, 1, 0)
    crown = np.array([0.0, 0.0, body.stature])
    rows = image.view.project(np.stack([ground, ground + crown]))[..., 1]
    measured = np.array([_measure(mask) for mask in masks])
    table = {
        tables.SEQUENCE: name,
        tables.SUBJECT: subject,
        tables.FRAME: np.arange(1, walk.n_frames + 1),
    }
    for column, name in enumerate((tables.X, tables.Y, tables.W, tables.H)):
        table[name] = measured[:, column].astype(int)
    table[tables.CX] = measured[:, 4]
    table[tables.CY] = measured[:, 5]
    table[tables.AREA] = measured[:, 6].astype(int)
    table[X_M] = motion.pelvis[:, 0]
    table[Y_M] = motion.pelvis[:, 1]
    table[SPEED] = motion.speed
    table[HEADING] = float(walk.heading)
    table[STATURE_PX] = rows[0] - rows[1]
    table[PHASE] = motion.phase % 1.0
    table[CUT] = image.clearance < 0
    return pd.DataFrame(table)


def _measure(mask):
    """Box, centroid and area (x, y, w, h, cx, cy, area) of a mask; all 0 when it is black."""
    x, y, w, h = cv2.boundingRect(mask)
    if w == 0:
        return (0.0,) * 7
    moments = cv2.moments(mask[y : y + h, x : x + w], binaryImage=True)
    area = moments["m00"]
    return x, y, w, h, x + moments["m10"] / area, y + moments["m01"] / area, area
