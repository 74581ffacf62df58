"""Master and slaves: the overhead camera wakes and turns the others (thesis section 2.2.5).

The overhead camera, the master, knows where everybody walks.  Frame by frame it decides
which pan-tilt-zoom camera, its slaves, watches whom and how fast it must pan; a camera
without a walker sleeps.  What is simulated is the geometry seen from above: places,
lines of sight, pan angles, the limits on them and the time that waking takes.  Tilt, zoom
and the master's own errors are left out.

A walker who passes at speed v calls for v·sin(a)/d radians a second, where d is the
distance and a the angle between course and line of sight: most of all square-on, which is
just where the thesis wants the camera.

Pan angles and bearings are degrees counter-clockwise from the x axis, seen from above.

References
----------
The assignment problem: H. W. Kuhn, The Hungarian method for the assignment problem, Naval
Research Logistics Quarterly 2, 1955.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab import tables
from mcnlab.cameras.visibility import CameraModel, sees, within_reach
from mcnlab.checks import HAIR, MOST_FAR, require_number
from mcnlab.compass import turn_between
from mcnlab.errors import ArgumentError, TableError
from mcnlab.tables import FRAME, TRACE, X, Y, check_columns

LOOK_BACK: Final = 0.5  # s of a walker's past from which the master tells its course
STILL: Final = 0.02  # m: who has moved by less in that time keeps the course it had
STATES: Final = ("watched", "waking", "turning", "lagging", "unwatched", "unseen")


@dataclass(frozen=True)
class PanTilt:
    """A slave: a camera that turns.

    Attributes
    ----------
    x, y : float
        Metres.
    field_of_view : float
        Degrees, half to either side of the pan angle.
    near, reach : float
        Metres; nearer than `near` or farther than `reach` it watches nobody.
    pan_limit : float
        Degrees a second; 180 a frame or more is no limit.
    wake_time : float
        Seconds from the call to the first picture; until then it does not turn.
    pan : float
        Where it looks at first, degrees.

    Examples
    --------
    >>> PanTilt(0.0, 2.5, pan_limit=90.0).reach
    12.0
    """

    x: float
    y: float
    field_of_view: float = 30.0
    near: float = 1.0
    reach: float = 12.0
    pan_limit: float = 60.0
    wake_time: float = 0.5
    pan: float = 0.0

    def __post_init__(self) -> None:
        require_number("x", self.x, low=-MOST_FAR, high=MOST_FAR, unit="metres")
        require_number("y", self.y, low=-MOST_FAR, high=MOST_FAR, unit="metres")
        require_number("field_of_view", self.field_of_view, above=0, high=360, unit="degrees")
        require_number("near", self.near, low=0, unit="metres")
        require_number("reach", self.reach, above=self.near, unit="metres, beyond near")
        require_number("pan_limit", self.pan_limit, low=0, unit="degrees a second")
        require_number("wake_time", self.wake_time, low=0, unit="seconds")
        require_number("pan", self.pan, unit="degrees")


@dataclass(frozen=True, eq=False)
class Log:
    """What the cameras did.

    Attributes
    ----------
    cameras : tuple of PanTilt
    frame_rate : float
        Frames a second.
    square_within : float
        Degrees off square-on that still count as square-on.
    table : pandas.DataFrame
        One row a frame and camera, from the first frame to the last: ``frame, camera,
        awake`` (called, or already watching), ``pan`` (degrees, −180 … 180), ``wanted``
        (the walker's bearing, degrees; where asleep, `pan`), ``rate`` (degrees a second by
        which it turned), ``needed`` (degrees a second by which the walker's bearing
        changes; 0 where asleep), ``trace`` (whom it watches; "" where asleep).
    walkers : pandas.DataFrame
        One row a row of the traces: ``trace, frame, camera`` (−1 where nobody watches),
        ``state``: "watched"; or why not: "waking", while the camera called wakes up;
        "turning", while it turns to a walker new to it; "lagging", when it had him in view
        but could not pan as fast; "unwatched", where those who could see him watch others;
        "unseen", where no camera could; and
        ``off_square``, degrees between the watcher's line of sight and the
        perpendicular to the walker's course (90 where nobody watches).
    """

    cameras: tuple[PanTilt, ...]
    frame_rate: float
    square_within: float
    table: pd.DataFrame
    walkers: pd.DataFrame

    @property
    def awake_share(self) -> pd.Series:
        """The share of the time that each camera is awake, by its number."""
        return self.table.groupby("camera")["awake"].mean()

    @property
    def hand_overs(self) -> pd.Series:
        """How often each walker's camera changes; times without one count not."""
        had = self.walkers[self.walkers["camera"] >= 0]
        trace, camera = had[TRACE].to_numpy(dtype=object), had["camera"].to_numpy()
        changed = np.r_[False, (trace[1:] == trace[:-1]) & (camera[1:] != camera[:-1])][: len(had)]
        names = pd.Index(pd.unique(self.walkers[TRACE]), name=TRACE)
        return pd.Series(changed, dtype=int).groupby(trace).sum().reindex(names, fill_value=0)

    @cached_property
    def summary(self) -> pd.Series:
        """The whole in a few numbers.

        Returns
        -------
        pandas.Series
            ``needed_median, needed_p95, needed_most``: absolute pan rates that the walkers
            call for, degrees a second, over the time that cameras are awake (0 if never).
            ``awake_share``: of camera-seconds.  ``walker_s``: walker-seconds in all, the
            sum of ``watched_s, waking_s, turning_s, lagging_s, unwatched_s, unseen_s``.
            Shares of the time in which some camera could see the walker (0 where none
            could): ``watched_share, waking_share, turning_share, lagging_share``, of those
            seconds; ``lost_share``, turning and lagging together, the time lost at the pan
            limit; ``square_share``, watched within `square_within` of square-on.
            ``hand_overs``: mean a walker.
        """
        needed = np.abs(self.table.loc[self.table["awake"], "needed"].to_numpy())
        needed = needed if len(needed) else np.zeros(1)
        state = self.walkers["state"].to_numpy(dtype=object)
        seconds = {f"{name}_s": float((state == name).sum() / self.frame_rate) for name in STATES}
        total = len(state) / self.frame_rate
        could = total - seconds["unseen_s"]
        square = (state == "watched") & (
            self.walkers["off_square"].to_numpy() <= self.square_within * (1 + HAIR)
        )
        shares = {f"{name}_share": seconds[f"{name}_s"] for name in STATES[:4]}
        shares["lost_share"] = seconds["turning_s"] + seconds["lagging_s"]
        shares["square_share"] = float(square.sum() / self.frame_rate)
        return pd.Series(
            {
                "needed_median": float(np.median(needed)),
                "needed_p95": float(np.quantile(needed, 0.95)),
                "needed_most": float(needed.max()),
                "awake_share": float(self.table["awake"].mean()),
                "walker_s": total,
                **seconds,
                **{name: part / could if could > 0 else 0.0 for name, part in shares.items()},
                "hand_overs": float(self.hand_overs.mean()),
            }
        )


def simulate(
    traces: pd.DataFrame,
    cameras: Iterable[PanTilt],
    *,
    frame_rate: float,
    square_within: float = 15.0,
    hysteresis: float = 10.0,
    look_back: float = LOOK_BACK,
    walls: ArrayLike | None = None,
) -> Log:
    """Let the overhead camera wake and turn the others.

    In every frame each camera watches one walker at most and each walker is watched by one
    camera at most.  Of all such assignments the master takes one that watches the most
    walkers, and among those the one whose lines of sight are the most nearly square-on, in
    all; a camera that already watches a walker is taken to be nearer to square-on by
    `hysteresis`, so that walkers are not handed to and fro.

    Parameters
    ----------
    traces : pandas.DataFrame
        A trace table, metres: what the master knows.
    cameras : sequence of PanTilt
    frame_rate : float
        Frames a second.
    square_within : float, optional
        Degrees off square-on that count as square-on in the summary.
    hysteresis : float, optional
        Degrees by which another camera must see a walker more nearly square-on, to get
        him.
    look_back : float, optional
        Seconds of a walker's past that tell its course.
    walls : array_like, shape (k, 2, 2), optional
        The ends of segments that block sight, metres.

    Returns
    -------
    Log

    Raises
    ------
    TableError, ArgumentError
        When the traces are not sound or jump in time, there is no camera, or a number is
        out of range.

    Examples
    --------
    A walker passes 5 m in front of a camera at 1.5 m/s; square-on it turns by 17° a second.

    >>> import numpy as np, pandas as pd
    >>> x = np.arange(-6, 6, 0.15)
    >>> walk = pd.DataFrame({"trace": "a", "frame": np.arange(len(x)), "x": x, "y": 5.0})
    >>> log = simulate(walk, [PanTilt(0.0, 0.0, pan=140.0)], frame_rate=10)
    >>> log.summary[["needed_most", "watched_share"]].round(2).to_dict()
    {'needed_most': 17.18, 'watched_share': 0.94}
    """
    tables.check_traces(traces)
    cameras = tuple(cameras) if isinstance(cameras, Iterable) else ()
    if not cameras or not all(isinstance(camera, PanTilt) for camera in cameras):
        raise ArgumentError("cameras must be PanTilt cameras, one at least; pass a list of them.")
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    square_within = require_number("square_within", square_within, low=0, high=90, unit="degrees")
    hysteresis = require_number("hysteresis", hysteresis, low=0, high=90, unit="degrees")
    look_back = require_number("look_back", look_back, above=0, unit="seconds")

    frame = traces[FRAME].to_numpy(dtype=np.int64)
    first, count = frame.min(), int(frame.max() - frame.min()) + 1
    if count > 10_000 + 20 * len(traces):
        raise TableError(
            f"traces span {count} frames with hardly anybody in them; number frames 1, 2, 3, …"
        )
    walk = traces[TRACE].to_numpy(dtype=object)
    starts = tables.starts_of(walk)
    walker = np.repeat(np.arange(len(starts)), np.diff(np.r_[starts, len(walk)]))
    places = traces[[X, Y]].to_numpy(float)
    bearing, possible = _look(places, cameras, walls)
    course = _courses(places, walker, frame - first, look_back * frame_rate)
    off_square = _off_square(course, bearing)
    needed = _bearing_rates(bearing, walker, frame, frame_rate)

    order = np.argsort(frame, kind="stable")
    bounds = np.searchsorted(frame[order], first + np.arange(count + 1))
    limit = np.array([camera.pan_limit / frame_rate for camera in cameras])
    half_view = np.array([camera.field_of_view / 2 for camera in cameras])
    wake_time = np.array([camera.wake_time * frame_rate for camera in cameras])
    pan = turn_between(np.array([camera.pan for camera in cameras], dtype=float), 0)
    watched = np.full(len(cameras), -1)  # whom each camera watches
    since = np.zeros(len(cameras))  # frame in which it was woken
    in_view = np.zeros(len(cameras), bool)  # whether it has had that walker in view
    pans, turns = np.empty((2, count, len(cameras)))
    rows_of = np.full((count, len(cameras)), -1)
    state = np.where(possible.any(axis=1), STATES.index("unwatched"), STATES.index("unseen"))
    camera_of = np.full(len(traces), -1)
    for now in range(count):
        rows = order[bounds[now] : bounds[now + 1]]
        keeps = walker[rows, None] == watched
        mine, chosen = _assign(possible[rows], off_square[rows] - hysteresis * keeps)
        mine = rows[mine]
        since[chosen] = np.where(watched[chosen] >= 0, since[chosen], now)
        in_view[chosen] &= watched[chosen] == walker[mine]
        watched[:] = -1
        watched[chosen] = walker[mine]
        rows_of[now, chosen] = mine
        ready = now - since[chosen] >= wake_time[chosen] - HAIR * (1 + wake_time[chosen])
        wanted = turn_between(bearing[mine, chosen], pan[chosen])
        turn = np.where(ready, np.clip(wanted, -limit[chosen], limit[chosen]), 0.0)
        turns[now] = 0.0
        turns[now, chosen] = turn
        pan = turn_between(pan + turns[now], 0)
        pans[now] = pan
        seen = np.abs(wanted - turn) <= half_view[chosen] * (1 + HAIR)
        late = np.where(in_view[chosen], STATES.index("lagging"), STATES.index("turning"))
        late = np.where(seen, STATES.index("watched"), late)
        state[mine] = np.where(ready, late, STATES.index("waking"))
        in_view[chosen] |= ready & seen
        camera_of[mine] = chosen
    chosen_off = off_square[np.arange(len(walk)), camera_of]
    walkers = {
        TRACE: walk,
        FRAME: frame,
        "camera": camera_of,
        "state": np.array(STATES, dtype=object)[state],
        "off_square": np.where(camera_of >= 0, chosen_off, 90.0),
    }
    table = _camera_table(first, pans, turns * frame_rate, rows_of, bearing, needed, walk)
    return Log(cameras, frame_rate, square_within, table, pd.DataFrame(walkers))


def _look(places, cameras, walls):
    """Bearings of places from cameras, degrees, and whether they could be seen; (n, m)."""
    stand = np.array([(camera.x, camera.y) for camera in cameras])
    line = places[:, None] - stand
    near, reach = np.array([(camera.near, camera.reach) for camera in cameras]).T
    # Right above the camera there is no bearing to turn to.
    possible = within_reach(np.hypot(line[..., 0], line[..., 1]), near, reach)
    if walls is not None:
        table = pd.DataFrame({X: stand[:, 0], Y: stand[:, 1], "heading": 0.0})
        far = CameraModel(near=0.0, reach=float(reach.max()), pans=True)
        possible &= sees(places, table, far, walls=walls)
    return np.degrees(np.arctan2(line[..., 1], line[..., 0])), possible


def _courses(places, walker, frame, back):
    """Each row's course, degrees: from where the walker was `back` frames ago.

    Who stands keeps the course that it had; who has just come has that of its first move,
    and who never moves has none (NaN).
    """
    # Walkers one after another on one axis of time, so that one search serves all.
    apart = float(frame.max()) + back + 2
    time = walker * apart + frame
    row = np.arange(len(time))
    alone = np.r_[True, walker[1:] != walker[:-1]]
    earlier = np.searchsorted(time, time - back - HAIR * (1 + back))
    earlier = np.where(alone, row, np.minimum(earlier, row - 1))
    step = places - places[earlier]
    moved = np.hypot(step[:, 0], step[:, 1]) >= STILL
    course = pd.Series(np.degrees(np.arctan2(step[:, 1], step[:, 0]))).where(moved)
    return course.groupby(walker).ffill().groupby(walker).bfill().to_numpy()


def _off_square(course, bearing):
    """Degrees between lines of sight and the perpendicular to the course; 90 without one."""
    off = 90.0 - np.abs((course[:, None] - bearing + 90.0) % 180.0 - 90.0)
    return np.where(np.isfinite(off), off, 90.0)


def _bearing_rates(bearing, walker, frame, frame_rate):
    """How fast bearings change since the row before, degrees a second, (n, m).

    A walker's first row has the second's rate; a single row has 0.
    """
    rates = np.zeros(bearing.shape)
    same = walker[1:] == walker[:-1]
    change = (
        turn_between(bearing[1:], bearing[:-1]) * (frame_rate / np.diff(frame).clip(1))[:, None]
    )
    rates[:-1][same] = change[same]
    rates[1:][same] = change[same]
    return rates


def _assign(possible, off_square):
    """Rows and columns of the assignment that `simulate` describes."""
    from scipy.optimize import linear_sum_assignment

    if not possible.any():
        return np.empty(0, int), np.empty(0, int)
    # One walker more outweighs any gain in angles: those sum to under 181 a pair.
    worth = np.where(possible, 181.0 * (1 + min(possible.shape)) + 90.0 - off_square, 0.0)
    row, column = linear_sum_assignment(worth, maximize=True)
    sound = possible[row, column]
    return row[sound], column[sound]


def _camera_table(first, pans, rates, rows_of, bearing, needed, walk):
    """`Log.table`."""
    count, number = rows_of.shape
    camera = np.tile(np.arange(number), count)
    row, pan = rows_of.ravel(), pans.ravel()
    awake = row >= 0
    return pd.DataFrame(
        {
            FRAME: np.repeat(first + np.arange(count), number),
            "camera": camera,
            "awake": awake,
            "pan": pan,
            "wanted": np.where(awake, bearing[row, camera], pan),
            "rate": rates.ravel(),
            "needed": np.where(awake, needed[row, camera], 0.0),
            TRACE: np.where(awake, walk[row], ""),
        }
    )


def slaves_at(
    cameras: pd.DataFrame,
    *,
    model: CameraModel,
    field_of_view: float = 30.0,
    pan_limit: float = 90.0,
) -> list[PanTilt]:
    """Panning cameras at chosen places, for `simulate`.

    Parameters
    ----------
    cameras : pandas.DataFrame
        ``x, y``.
    model : CameraModel
        How near and how far they see.
    field_of_view : float, optional
        Degrees.
    pan_limit : float, optional
        Degrees a second.

    Returns
    -------
    list of PanTilt
        One a row of `cameras`.

    Raises
    ------
    TableError, ArgumentError
        When ``x`` or ``y`` is missing, or a number is out of range.
    """
    check_columns(cameras, (X, Y), argument="cameras")
    sees = {"near": model.near, "reach": model.reach}
    return [
        PanTilt(x, y, field_of_view=field_of_view, pan_limit=pan_limit, **sees)
        for x, y in cameras[[X, Y]].itertuples(index=False)
    ]
