"""The synthetic corridor filmed from the top floor: frames, and every foot's true place.

A pinhole camera looks down over the parapet, as in the thesis's Figure 2.7.  Walkers are
drawn as a dozen thick strokes each, sized and placed by perspective, on a textured floor,
with shadows, flicker and sensor noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, NamedTuple

import cv2
import numpy as np
import pandas as pd

from mcnlab.cameras.camera import Camera
from mcnlab.checks import require_count, require_number
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.corridor import Corridor, make_corridor
from mcnlab.tables import FRAME, TRACE, X, Y

# A fixed camera at the top floor, looking north over the corridor.
TOP_FLOOR: Final = Camera.from_tilt(
    focal_length=430.0,
    height=13.0,
    tilt=60.0,
    frame_width=384,
    frame_height=216,
    place=(5.75, -4.4),
)

# Heights, metres.
_WALL: Final = 2.6
_PARAPET: Final = 0.7
_PLANTER: Final = 0.3
_POST: Final = 2.4
_SHADOW: Final = np.array([0.35, 0.45])  # metres, where a walker's shadow falls


@dataclass(frozen=True, eq=False)
class RenderedCorridor:
    """A video of the corridor, with truth.

    Attributes
    ----------
    frames : ndarray of uint8, shape (n, height, width)
    frame_rate : float
        Frames a second.
    homography : ndarray, shape (3, 3)
        Image to ground, exact.
    image_points, ground_points : ndarray, shape (6, 2)
        The crosses painted on the floor: whole pixels, as one reads them off the image, and
        metres.
    truth : Scene
        The feet of those who are in these frames, metres; frame 0 is the first one here.
    feet : pandas.DataFrame
        The same in pixels, and ``hidden``: whether stairs or parapet hide the feet.
    """

    frames: np.ndarray
    frame_rate: float
    homography: np.ndarray
    image_points: np.ndarray
    ground_points: np.ndarray
    truth: Scene
    feet: pd.DataFrame


def render_corridor(
    corridor: Corridor | None = None,
    camera: Camera | None = None,
    *,
    walkers: int = 40,
    seed: int = 0,
    start: float = 0.0,
    seconds: float | None = None,
    noise: float = 2.0,
) -> RenderedCorridor:
    """A video of people in the corridor, with truth.

    Parameters
    ----------
    corridor : Corridor, optional
    camera : Camera, optional
        Default: `TOP_FLOOR`.
    walkers, seed : int, optional
        As in `make_corridor`; 40 walkers take three to four minutes.
    start : float, optional
        Seconds to leave out at the beginning.
    seconds : float, optional
        Length; until the last walker has gone if not given.
    noise : float, optional
        Standard deviation of the sensor's noise, grey levels.

    Returns
    -------
    RenderedCorridor

    Raises
    ------
    ArgumentError
        When an argument is impossible or nobody is there in that time.

    Examples
    --------
    >>> film = render_corridor(walkers=2, seconds=1)
    >>> film.frames.shape, film.frame_rate
    ((10, 216, 384), 10.0)
    """
    corridor = Corridor() if corridor is None else corridor
    camera = TOP_FLOOR if camera is None else camera
    noise = require_number("noise", noise, low=0, high=50, unit="grey levels")
    scene = make_corridor(corridor, walkers=walkers, seed=seed)
    rate = scene.frame_rate
    first = round(require_number("start", start, low=0, unit="seconds") * rate)
    stop = int(scene.traces[FRAME].max()) + 1
    if seconds is not None:
        seconds = require_number("seconds", seconds, low=1, unit="seconds")
        stop = min(stop, first + round(seconds * rate))
    there = scene.traces[FRAME].between(first, stop - 1)
    if not there.any():
        raise ArgumentError(
            f"start is {start:g} s, seconds is {seconds}: nobody is there then; the walkers come "
            f"from {scene.traces[FRAME].min() / rate:g} to {scene.traces[FRAME].max() / rate:g} s."
        )
    frames = np.empty((stop - first, camera.frame_height, camera.frame_width), np.uint8)
    drawn = render_frames(scene, camera, corridor, start=first, stop=stop, noise=noise, seed=seed)
    for number, frame in enumerate(drawn):
        frames[number] = frame
    traces = scene.traces[there]
    truth = scene.with_traces(traces.assign(**{FRAME: traces[FRAME] - first}))
    pixels = camera.project(truth.traces[[X, Y]])
    feet = truth.traces.assign(**{X: pixels[:, 0], Y: pixels[:, 1]})
    marks = _marks(corridor)
    return RenderedCorridor(
        frames=frames,
        frame_rate=rate,
        homography=camera.homography,
        image_points=np.round(camera.project(marks)),
        ground_points=marks,
        truth=truth,
        feet=feet.assign(hidden=_is_hidden(corridor, camera, pixels)),
    )


def render_frames(
    scene: Scene,
    camera: Camera | None = None,
    corridor: Corridor | None = None,
    *,
    start: int = 0,
    stop: int | None = None,
    noise: float = 2.0,
    seed: int = 0,
) -> Iterator[np.ndarray]:
    """Draw a scene's walkers in the corridor, frame by frame.

    A walker is a dozen thick strokes, placed and sized by perspective, with swinging legs and
    arms and a soft shadow; the light flickers by 0.8 %.

    Parameters
    ----------
    scene : Scene
        Walkers in the corridor, as from `make_corridor`.
    camera : Camera, optional
        Default: `TOP_FLOOR`.
    corridor : Corridor, optional
    start, stop : int, optional
        The first frame and the one after the last; the whole scene if not given.
    noise : float, optional
        Standard deviation of the sensor's noise, grey levels.
    seed : int, optional
        Of the noise, the walkers' clothes and their size.

    Yields
    ------
    ndarray of uint8, shape (height, width)
    """
    camera = TOP_FLOOR if camera is None else camera
    corridor = Corridor() if corridor is None else corridor
    noise = require_number("noise", noise, low=0, high=50, unit="grey levels")
    start = require_count("start", start)
    stop = int(scene.traces[FRAME].max()) + 1 if stop is None else require_count("stop", stop)
    if stop <= start:
        raise ArgumentError(f"stop is {stop}, start {start}; pass a stop after the start.")
    rng = np.random.default_rng(require_count("seed", seed))
    background, hiding = _paint(corridor, camera)
    people = _draw_up(scene, camera, rng, start, stop)
    posts = [_post(camera, place) for place in corridor.best_places]
    size = camera.frame_width, camera.frame_height
    sensor = rng.standard_normal(8 * size[0] * size[1], dtype=np.float32)
    for frame in range(start, stop):
        canvas = background.copy()
        here = people.get(frame, [])
        if here:
            canvas = cv2.multiply(canvas, _shade(here, size), scale=1 / 255)
        for thing in sorted([*here, *posts], key=lambda thing: -thing.depth):
            for points, grey, width in thing.strokes:
                _stroke(canvas, points, grey, thing.scale * width)
        cv2.copyTo(background, hiding, canvas)
        image = cv2.resize(canvas, size, interpolation=cv2.INTER_AREA).astype(np.float32)
        gain = 1.0 + 0.008 * np.sin(frame * 2 * np.pi / 17.3)
        # A random stretch of one long noise: as good as fresh, and much faster.
        at = rng.integers(len(sensor) - image.size)
        grain = sensor[at : at + image.size].reshape(image.shape)
        yield cv2.addWeighted(image, gain, grain, noise, 0, dtype=cv2.CV_8U)


class _Thing(NamedTuple):
    """Something upright: thick strokes, and how far off it is."""

    depth: float  # metres
    scale: float  # doubled pixels a metre, there
    strokes: list  # (points, shape (n, 2), doubled pixels; grey; width in metres)
    shadow: np.ndarray = None


# Everything is drawn at twice the size and then halved: smooth edges, and movement by parts
# of a pixel.  Pixel p of the frame is 2p + 1/2 there.


def _doubled(camera, points, height=0.0):
    return 2 * camera.project(_raised(points, height)) + 0.5


def _raised(points, height):
    """Points of the ground at a height, or one height each; shape (n, 3), metres."""
    return np.c_[points, np.broadcast_to(height, len(points))]


def _sixteenths(points):
    """What OpenCV draws with shift 4."""
    return [np.round(16 * np.asarray(points)).astype(np.int32)]


def _stroke(canvas, points, grey, width):
    """A line with round ends; a dot when its points are the same."""
    width = max(1, round(float(width)))
    cv2.polylines(canvas, _sixteenths(points), False, int(grey), width, cv2.LINE_AA, 4)


def _shade(people, size):
    """What remains of the light, 255 = all: soft shadows, doubled."""
    shade = np.zeros(size[::-1], np.uint8)
    for person in people:
        _stroke(shade, (person.shadow - 0.5) / 2, 255, person.scale * 0.17)
    shade = cv2.GaussianBlur(shade, (0, 0), 1.5)
    shade = cv2.addWeighted(shade, -0.35, shade, 0, 255)
    return cv2.resize(shade, (2 * size[0], 2 * size[1]), interpolation=cv2.INTER_LINEAR)


def _range(camera, places):
    """Depth of people at places, metres, and doubled pixels a metre there."""
    depth = camera.depth(_raised(places, 1.0))  # of the chest
    return depth, 2 * camera.focal_length / depth


def _post(camera, place):
    foot, top = _doubled(camera, np.array([place, place]), [_PLANTER, _POST])
    depth, scale = _range(camera, place[None])
    return _Thing(depth[0], scale[0], [([foot, top], 60, 0.06), ([top, top], 40, 0.14)])


def _draw_up(scene, camera, rng, start, stop):
    """What to draw: frame number → list of things."""
    people = {}
    for _, walk in scene.traces.groupby(TRACE, sort=False):
        things = _person(walk[[X, Y]].to_numpy(float), scene.frame_rate, camera, rng)
        for frame, thing in zip(walk[FRAME].to_numpy(), things, strict=True):
            if start <= frame < stop:
                people.setdefault(int(frame), []).append(thing)
    return people


def _person(places, frame_rate, camera, rng):
    """One walker at each of its places; yields things."""
    size = rng.uniform(0.93, 1.07)  # of 1.75 m
    # Darker than half the floor or lighter than it.  In between one cannot tell clothes from
    # shadows in a grey video; in a colour video one could.
    hair, trousers = rng.uniform(20, 60, 2)
    coat = rng.uniform(25, 60) if rng.random() < 0.6 else rng.uniform(215, 240)
    velocity = np.zeros_like(places)
    if len(places) > 4:
        velocity = np.gradient(places, axis=0) * frame_rate
        even = np.full(5, 0.2)
        for axis in (0, 1):
            velocity[:, axis] = np.convolve(velocity[:, axis], even, mode="same")
    speed = np.linalg.norm(velocity, axis=1)
    # Who stands still keeps facing where they went.
    last = np.maximum.accumulate(np.where(speed > 0.3, np.arange(len(places)), 0))
    ahead = velocity[last] / np.maximum(speed[last], 1e-9)[:, None]
    right = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
    phase = rng.uniform(0, 2 * np.pi) + np.cumsum(speed / frame_rate) * 2 * np.pi / (1.4 * size)
    swing = (np.sin(phase) * np.minimum(1.0, speed / 0.9))[:, None]

    def joint(height, *, forward=0.0, sideways=0.0):
        points = places + size * (forward * ahead + sideways * right)
        return _doubled(camera, points, size * height)

    hip = [joint(0.88, sideways=side * 0.07) for side in (-1, 1)]
    ankle = [joint(0.04, sideways=side * 0.07, forward=side * 0.28 * swing) for side in (-1, 1)]
    shoulder = [joint(1.38, sideways=side * 0.17) for side in (-1, 1)]
    hand = [joint(0.82, sideways=side * 0.26, forward=-side * 0.22 * swing) for side in (-1, 1)]
    waist, chest = joint(0.98), joint(1.28)
    face, crown = joint(1.62, forward=0.03), joint(1.66)
    strokes = (
        (hip[0], ankle[0], trousers, 0.13),
        (hip[1], ankle[1], trousers, 0.13),
        (shoulder[0], hand[0], coat - 8, 0.08),
        (waist, chest, coat, 0.30),
        (shoulder[0], shoulder[1], coat + 10, 0.15),
        (shoulder[1], hand[1], coat - 8, 0.08),
        (face, face, 175, 0.20),
        (crown, crown, hair, 0.20),
    )
    shadow = np.stack([joint(0.0), _doubled(camera, places + _SHADOW)], axis=1)
    depth, scale = _range(camera, places)
    for row in range(len(places)):
        lines = [([a[row], b[row]], grey, width) for a, b, grey, width in strokes]
        yield _Thing(depth[row], size * scale[row], lines, shadow[row])


def _marks(corridor):
    """Six crosses on the floor, metres."""
    left, bottom, right, top = corridor.inside
    return np.array(
        [
            [left + 0.5, bottom + 0.6],
            [(left + right) / 2, bottom + 0.6],
            [right - 0.5, bottom + 0.6],
            [right - 0.5, top - 0.5],
            [(corridor.stairs[2] + right) / 2, top - 0.5],
            [left + 0.5, top - 0.5],
        ]
    )


def _is_hidden(corridor, camera, pixels):
    """Whether stairs or parapet cover each pixel."""
    _, hiding = _paint(corridor, camera)
    column, row = np.round(2 * pixels + 0.5).astype(int).T
    rows, columns = hiding.shape
    within = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return ~within | (hiding[row.clip(0, rows - 1), column.clip(0, columns - 1)] > 0)


@lru_cache(maxsize=4)
def _paint(corridor, camera):
    """The empty corridor, doubled, and where stairs or parapet hide walkers."""
    canvas = _paint_floor(corridor, camera)
    _paint_walls(canvas, corridor, camera)
    _paint_planter(canvas, corridor, camera)
    alone = np.zeros_like(canvas)
    for image in (canvas, alone):
        _paint_front(image, corridor, camera)
    hiding = np.where(alone > 0, np.uint8(255), np.uint8(0))
    canvas.setflags(write=False)
    hiding.setflags(write=False)
    return canvas, hiding


def _upright(image, camera, start, stop, grey, low, high):
    """A rectangle that stands on the ground from `start` to `stop`."""
    pixels = _doubled(camera, np.array([start, stop, stop, start]), [low, low, high, high])
    cv2.fillPoly(image, _sixteenths(pixels), grey, cv2.LINE_AA, 4)


def _flat(image, camera, outline, height, grey):
    """A polygon that lies at a height."""
    pixels = _doubled(camera, np.asarray(outline, float), height)
    cv2.fillPoly(image, _sixteenths(pixels), grey, cv2.LINE_AA, 4)


def _box(left, bottom, right, top):
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


def _paint_floor(corridor, camera):
    """Worn tiles, marks and the yard; textures are drawn on the map and then seen."""
    left, bottom, right, top = corridor.inside
    reach, scale = 3.0, 60  # metres of yard, pixels a metre
    x = np.arange(left - reach, right + reach, 1 / scale)
    y = np.arange(bottom - reach, top + reach, 1 / scale)
    rng = np.random.default_rng(5)

    def clouds(size, amount):
        coarse = rng.standard_normal((len(y) // size + 2, len(x) // size + 2), dtype=np.float32)
        return amount * cv2.resize(coarse, (len(x), len(y)), interpolation=cv2.INTER_CUBIC)

    side = 0.6  # metres of a tile
    tiles = rng.normal(0, 4, (200, 200))
    tiles = tiles[np.ix_((y // side).astype(int) % 200, (x // side).astype(int) % 200)]
    joints = np.logical_or.outer(y % side < 0.025, x % side < 0.025)
    floor = 150 + tiles - 26 * joints + clouds(90, 5) + clouds(12, 2.5) + clouds(2, 2.5)
    # Corners are darker: they see less of the sky.
    corner = np.minimum.outer(top - y, np.minimum(x - left, right - x)).clip(0)
    floor *= 1 - 0.28 * np.exp(-corner / 0.35)
    indoors = np.logical_and.outer(y >= bottom - 0.1, (x >= left) & (x <= right))
    ground = np.where(indoors, floor, 96 + clouds(30, 6) + clouds(3, 7))
    ground = ground.clip(0, 255).astype(np.uint8)
    for mark in _marks(corridor):
        at = np.round((mark - [x[0], y[0]]) * scale).astype(int)
        cv2.drawMarker(ground, tuple(map(int, at)), 235, cv2.MARKER_CROSS, 20, 4)
    to_ground = np.array([[1 / scale, 0, x[0]], [0, 1 / scale, y[0]], [0, 0, 1]])
    double = np.array([[2, 0, 0.5], [0, 2, 0.5], [0, 0, 1]])
    seen = double @ np.linalg.inv(camera.homography) @ to_ground
    size = 2 * camera.frame_width, 2 * camera.frame_height
    return cv2.warpPerspective(ground, seen, size, borderMode=cv2.BORDER_REPLICATE)


def _paint_walls(canvas, corridor, camera):
    left, bottom, right, top = corridor.inside
    thick = 0.25
    west, east = ((left, bottom), (left, top)), ((right, bottom), (right, top))
    north = ((left, top), (right, top))
    for wall, grey in ((north, 176), (west, 166), (east, 156)):
        _upright(canvas, camera, *wall, grey, 0.0, _WALL)
        _upright(canvas, camera, *wall, 105, 0.0, 0.1)
    for x in np.arange(left + 0.6, right - 1.2, 1.9):
        _upright(canvas, camera, (x, top), (x + 1.0, top), 112, 1.0, 2.1)
    for strip in (
        _box(left - thick, bottom, left, top),
        _box(right, bottom, right + thick, top),
        _box(left - thick, top, right + thick, top + thick),
    ):
        _flat(canvas, camera, strip, _WALL, 224)
    for x in corridor.doors:
        _flat(canvas, camera, _box(x - 0.5, bottom + 0.1, x + 0.5, bottom + 0.45), 0.0, 105)


def _paint_planter(canvas, corridor, camera):
    points, normals = corridor.spine
    for height in np.linspace(0.0, _PLANTER, 7):
        _flat(canvas, camera, points, height, 112)
    _flat(canvas, camera, points, _PLANTER, 150)
    _flat(canvas, camera, points - 0.07 * normals, _PLANTER, 78)
    rng = np.random.default_rng(7)
    start, stop = corridor.best_places
    share = rng.uniform(-0.03, 1.03, (260, 1))
    leaves = start + share * (stop - start)
    leaves[:, 1] += corridor.planter * rng.uniform(-0.6, 0.6, 260)
    for leaf in _doubled(camera, leaves, _PLANTER + 0.1):
        _stroke(canvas, [leaf, leaf], rng.uniform(55, 120), rng.uniform(4, 9))


def _paint_front(image, corridor, camera):
    """Stairs and parapet."""
    left, bottom, right, top = corridor.inside
    west, south, east = corridor.stairs
    _upright(image, camera, (west, south), (east, south), 168, 0.0, _WALL)
    _upright(image, camera, (west, south), (east, south), 98, 0.0, 0.1)
    for x in np.linspace(west, east, 5)[:-1]:
        _upright(image, camera, (x + 0.2, south), (x + 0.7, south), 112, 1.0, 2.0)
    _flat(image, camera, _box(west, south, east, top), _WALL, 212)
    _flat(image, camera, _box(west + 0.12, south + 0.12, east - 0.12, top), _WALL, 196)
    front = bottom - 0.12
    posts = [x + half for x in sorted(corridor.doors) for half in (-0.55, 0.55)]
    ends = [left - 0.25, *posts, right + 0.25]
    for start, stop in zip(ends[::2], ends[1::2], strict=True):
        _upright(image, camera, (start, front), (stop, front), 140, 0.0, _PARAPET)
        _flat(image, camera, _box(start, front, stop, bottom), _PARAPET, 214)
