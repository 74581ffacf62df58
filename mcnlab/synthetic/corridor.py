"""A synthetic corridor seen from the top floor, where the best camera places are known.

It stands in for the hall's corridor of the thesis's experiment (section 2.3), whose plan is
not published but whose votes have two humps, at cells (4, 4) and (5, 18).  Here a corridor
runs round both ends of a planter.  People walk in lanes concentric with the two bends, so
every perpendicular of a bend meets in its centre: the two centres are the best places for
cameras, and they lie in the middle of cells (4, 4) and (5, 18) of a grid of 10 × 23 half
metres, rows counted upwards as in `GridMap`.  A post stands at each.

    ┌───────────┬──────────────┬───────────┐    stairs   a closed block that blocks sight, as
    │    arm    │    stairs    │    arm    │             the outer walls do; a door to each arm
    │   ╭───────┴──────────────┴───────╮   │    planter  low, blocks nothing; built against the
    │   │ post       planter      post │   │             stairs
    │   ╰──────────────────────────────╯   │    parapet  the front of the corridor, low, open at
    │  bend        corridor        bend    │             the doors; the camera looks over it
    └─ ─ ─ ─ door─ parapet ─ ─door─ ─ ─ ─ ─┘

Ground coordinates are metres, x to the right and y up (north).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
import pandas as pd

from mcnlab.cameras.floor import check_area
from mcnlab.checks import require_count, require_number
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.tables import FRAME, TRACE, X, Y

FRAME_RATE: Final = 10.0  # frames a second
KINDS: Final = ("through", "door", "linger", "cross")
SHARES: Final = (0.64, 0.16, 0.12, 0.08)  # of the kinds
WALKING_SPEED: Final = (1.1, 1.5)  # m/s, between people
_STEP: Final = 0.02  # metres between the points of a planned path


@dataclass(frozen=True)
class Corridor:
    """The plan.

    Attributes
    ----------
    area : tuple of float
        Left, bottom, right, top, metres; walls and parapet stand 5 cm inside.
    centres : tuple of pairs
        The left and the right bend's centre, metres.
    lanes : tuple of float
        Radius of the innermost and of the outermost lane, metres.
    planter : float
        Half the planter's width, metres.
    stairs : tuple of float
        Left, bottom and right of the block between the arms, metres; its top is the wall.
    doors : tuple of float
        x of the doorways in the parapet, metres.
    """

    area: tuple = (0.0, 0.0, 11.5, 5.0)
    centres: tuple = ((2.25, 2.25), (9.25, 2.75))
    lanes: tuple = (0.6, 1.9)
    planter: float = 0.4
    stairs: tuple = (3.95, 2.8, 7.55)
    doors: tuple = (4.4, 7.2)

    def __post_init__(self) -> None:
        left, bottom, right, top = check_area(self.area)
        for name, shape in (
            ("centres", (2, 2)),
            ("lanes", (2,)),
            ("planter", ()),
            ("stairs", (3,)),
        ):
            _require_numbers(name, getattr(self, name), shape)
        _require_numbers("doors", self.doors, (len(self.doors),))
        (ax, ay), (bx, by) = self.centres
        inner, outer = self.lanes
        west, south, east = self.stairs
        if not self.doors or not all(left + 0.5 <= x <= right - 0.5 for x in self.doors):
            raise ArgumentError(
                f"doors are at {self.doors}; pass at least one x, half a metre inside the area."
            )
        if not 0 < self.planter < inner < outer:
            raise ArgumentError(
                f"planter is {self.planter:g} m and lanes are {self.lanes} m; the planter must be "
                "narrower than the inner lane, and that than the outer lane."
            )
        room = min(ax - left, right - bx, ay - bottom, by - bottom, top - ay, top - by)
        if room < outer + 0.05:
            raise ArgumentError(
                f"centres {self.centres} leave lanes of {outer:g} m only {room:g} m of room to the "
                "area's edge; move them."
            )
        if not (ax < west < east < bx and max(ay, by) < south < top):
            raise ArgumentError(
                f"stairs are {self.stairs}; they must stand between the centres and north of them."
            )

    @property
    def best_places(self) -> np.ndarray:
        """The bends' centres, shape (2, 2), metres: where perpendiculars meet."""
        return np.array(self.centres)

    @property
    def walls(self) -> np.ndarray:
        """Segments that block sight, shape (6, 2, 2): three outer walls, three of the stairs.

        The planter and the parapet are lower than any camera.
        """
        left, bottom, right, top = self.inside
        west, south, east = self.stairs
        outer = np.array([[left, bottom], [left, top], [right, top], [right, bottom]])
        stairs = np.array([[west, top], [west, south], [east, south], [east, top]])
        return np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in (outer, stairs)])

    @property
    def inside(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top of the floor, metres."""
        left, bottom, right, top = self.area
        return left + 0.05, bottom + 0.05, right - 0.05, top - 0.05

    def mirrored(self) -> "Corridor":
        """The same corridor with left and right exchanged."""
        width = self.area[0] + self.area[2]
        west, south, east = self.stairs
        return replace(
            self,
            centres=tuple((width - x, y) for x, y in reversed(self.centres)),
            stairs=(width - east, south, width - west),
            doors=tuple(width - x for x in reversed(self.doors)),
        )

    @cached_property
    def spine(self) -> tuple[np.ndarray, np.ndarray]:
        """The planter's edge from the left arm's end to the right's, and its normals.

        Returns
        -------
        points, normals : ndarray, shape (n, 2)
            Metres, about 2 cm apart; a lane of radius r runs at
            ``points + (r − planter)·normals``.
        """
        (a, b), radius = np.array(self.centres), self.planter
        tilt = np.arctan2(*(b - a)[::-1])
        # Round the left post, counter-clockwise from north, along the front, round the right.
        left = _turn(np.pi / 2, 1.5 * np.pi + tilt, radius)
        right = _turn(-np.pi / 2 + tilt, np.pi / 2, radius)
        bends = a + radius * left, b + radius * right
        doors = (self.stairs[0], bends[0][0, 1]), (self.stairs[2], bends[1][-1, 1])
        lines = [
            _line(doors[0], bends[0][0]),
            _line(bends[0][-1], bends[1][0]),
            _line(bends[1][-1], doors[1]),
        ]
        # A line's last point is the bend's first.
        points = lines[0][:-1], bends[0], lines[1][1:-1], bends[1], lines[2][1:]
        normals = [
            np.broadcast_to(normal, piece.shape)
            for normal, piece in zip(
                (left[0], left, left[-1], right, right[-1]), points, strict=True
            )
        ]
        return np.concatenate(points), np.concatenate(normals)


def _require_numbers(name, value, shape):
    """Raise unless `value` holds finite numbers in that shape."""
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(f"{name} is {value!r}; pass numbers (metres).") from fault
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise ArgumentError(f"{name} is {value!r}; pass finite numbers of shape {shape} (metres).")


def make_corridor(
    corridor: Corridor | None = None,
    *,
    walkers: int = 150,
    seed: int = 0,
    frame_rate: float = FRAME_RATE,
    per_minute: float = 12.0,
) -> Scene:
    """People walking in the corridor, their true feet.

    Of the walkers about 64 % go from one end to the other, in either sense; 16 % come or go
    through a door; 12 % go through but stand about for a while; 8 % cross from a door to the
    planter, linger there and go back.  They arrive at random (Poisson), the
    first at once, each in a lane of
    their own, sway about it by a few centimetres and vary their pace.  They do not avoid
    one another.

    Parameters
    ----------
    corridor : Corridor, optional
    walkers : int, optional
    seed : int, optional
        The same seed gives the same people.
    frame_rate : float, optional
        Frames a second.
    per_minute : float, optional
        Arrivals, on average; 0.1 to 6000.

    Returns
    -------
    Scene
        Named "corridor".

    Raises
    ------
    ArgumentError
        When an argument is impossible.

    Examples
    --------
    >>> scene = make_corridor(walkers=5)
    >>> scene.traces["trace"].nunique(), scene.frame_rate
    (5, 10.0)
    """
    corridor = Corridor() if corridor is None else corridor
    walkers = require_count("walkers", walkers, low=1)
    frame_rate = require_number("frame_rate", frame_rate, low=1, high=200, unit="frames a second")
    per_minute = require_number("per_minute", per_minute, low=0.1, high=6000)
    rng = np.random.default_rng(require_count("seed", seed))
    arrivals = np.cumsum(rng.exponential(60.0 / per_minute, walkers))
    arrivals -= arrivals[0]
    kinds = rng.choice(len(KINDS), walkers, p=SHARES)
    tables = []
    for number, (arrival, kind) in enumerate(zip(arrivals, kinds, strict=True), start=1):
        path, stops = _plan(corridor, KINDS[kind], rng)
        places = _walk(path, stops, frame_rate, rng)
        frame = int(arrival * frame_rate) + np.arange(len(places))
        name = f"{KINDS[kind]}-{number}"
        tables.append(pd.DataFrame({TRACE: name, FRAME: frame, X: places[:, 0], Y: places[:, 1]}))
    west, south, east = corridor.stairs
    return Scene(
        name="corridor",
        traces=pd.concat(tables, ignore_index=True),
        frame_rate=frame_rate,
        area=corridor.area,
        walls=corridor.walls,
        blocks=[(west, south, east, corridor.area[3])],
        source="synthetic",
    )


def _turn(start, stop, radius):
    """Unit vectors from one angle to another, some 2 cm apart on a circle."""
    angle = np.linspace(start, stop, max(2, round(radius * abs(stop - start) / _STEP)))
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _line(start, stop):
    start, stop = np.asarray(start, float), np.asarray(stop, float)
    share = np.linspace(0, 1, max(2, round(np.linalg.norm(stop - start) / _STEP)))
    return start + share[:, None] * (stop - start)


def _sway(length, rng):
    """A smooth sideways wander of about 5 cm along a path, metres."""
    s = np.arange(length) * _STEP
    period, phase = rng.uniform(2.5, 6.0, 3), rng.uniform(0, 2 * np.pi, 3)
    return 0.04 * np.sin(2 * np.pi * s[:, None] / period + phase).sum(axis=1)


def _even(path):
    """The path's points again, evenly spaced."""
    far = np.r_[0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    at = np.arange(0, far[-1], _STEP)
    return np.stack([np.interp(at, far, path[:, axis]) for axis in (0, 1)], axis=1)


def _plan(corridor, kind, rng):
    """A path, shape (n, 2), and the stops on it: rows of (share of the path, seconds)."""
    points, normals = corridor.spine
    inner, outer = corridor.lanes
    if kind == "cross":
        return _crossing(corridor, rng)
    margin = 0.12  # of the lanes' width, that swaying walkers keep to
    radius = rng.uniform(inner + margin, outer - margin)
    offset = np.clip(radius + _sway(len(points), rng), inner, outer) - corridor.planter
    path = points + offset[:, None] * normals
    stops = []
    if kind == "linger":
        stops = [(rng.uniform(0.1, 0.9), rng.uniform(4, 12))]
    if kind == "door":
        # From the door the walker turns into the lane over about a metre.
        door = np.array([rng.choice(corridor.doors), corridor.area[1] + 0.1])
        ahead = path[:, 1] < corridor.best_places[:, 1].mean() - 0.3
        side = rng.choice([-1, 1])
        gap = np.where(ahead, np.abs(path[:, 0] - door[0] - side * 1.0), np.inf)
        join = int(gap.argmin())
        rest = path[join:] if side > 0 else path[join::-1]
        turn = np.array([door[0] + 0.2 * side, path[join, 1]])
        share = np.linspace(0, 1, 60)[:, None]  # a quadratic Bézier curve
        bend = (1 - share) ** 2 * door + 2 * share * (1 - share) * turn + share**2 * rest[0]
        path = np.r_[bend, rest[1:]]
    path = _even(path)
    return (path[::-1] if rng.random() < 0.5 else path), stops


def _crossing(corridor, rng):
    """From a door to the planter and back."""
    (ax, ay), (bx, by) = corridor.centres
    door = np.array([rng.choice(corridor.doors), corridor.area[1] + 0.1])
    x = door[0] + rng.uniform(-0.8, 0.8)
    edge = np.interp(x, [ax, bx], [ay, by]) - corridor.lanes[0]
    out = _line(door, [x, edge])
    # Back by a slightly other way.
    half = np.array([x + rng.uniform(-0.4, 0.4), (edge + door[1]) / 2])
    path = np.r_[out, _line(out[-1], half)[1:], _line(half, door)[1:]]
    share = len(out) / len(path)
    return _even(path), [(share, rng.uniform(4, 15))]


def _walk(path, stops, frame_rate, rng):
    """Feet along a path, one row a frame, with a natural pace and restless stops."""
    pace = rng.uniform(*WALKING_SPEED)
    time = np.arange(0, 10 * len(path) * _STEP / pace, 1 / frame_rate)
    wobble = 0.06 * np.sin(2 * np.pi * time / rng.uniform(3, 6) + rng.uniform(0, 2 * np.pi))
    far = np.cumsum(pace * (1 + wobble)) / frame_rate
    at = np.searchsorted(far, (len(path) - 1) * _STEP)
    rows = np.stack(
        [np.interp(far[:at], np.arange(len(path)) * _STEP, path[:, axis]) for axis in (0, 1)],
        axis=1,
    )
    for share, seconds in stops:
        stop = int(share * (len(rows) - 1))
        count = round(seconds * frame_rate)
        # A lingerer shifts about within a few centimetres, and comes back to where he stood.
        drift = np.cumsum(rng.normal(0, 0.02, (count, 2)), axis=0)
        drift -= np.linspace(0, 1, count)[:, None] * drift[-1]
        drift *= 0.12 / max(0.12, np.abs(drift).max())
        rows = np.r_[rows[:stop], rows[stop] + drift, rows[stop:]]
    return rows
