"""Pairs of walkers a moment before they might cover each other, and what then happens.

One definition for every recording of boxes.  A *pair at time t* is two walkers, t a whole
second: both have a box now, half a second ago, at the start of the last second and in most
of its frames; in most of the next three seconds' frames both have one; and now they hardly
cover each other.  *Cover* is the area of two boxes' intersection as a share of the smaller
box.  They *occlude* when, within the next three seconds, the cover exceeds 0.3 at a frame
that boxes both; that frame is the time, the intersection's centre the place.

The two walkers may come from one recording, or from two walks of one camera laid on top of
each other, the second begun some frames later (a composite; thesis section 3.5).
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mcnlab.columns import H, W, X, Y
from mcnlab.errors import ArgumentError, DatasetError, require_count, require_number
from mcnlab.lines import fit_lines_robust
from mcnlab.perspective import DEPTH_RANGE

CHUNK = 4096  # pairs whose futures are laid out at once
HORIZON_BOXES = 3000  # boxes are enough to see the horizon


@dataclass(frozen=True)
class Rules:
    """What counts as a pair, and as occlusion.

    Attributes
    ----------
    observed : float
        Seconds before the moment that a forecaster may see.
    horizon : float
        Seconds after it in which an occlusion counts.
    cover : float
        The cover that must be exceeded for occlusion.
    apart : float
        The most cover at the moment itself.
    seen : float
        Share of the observed frames with a box, at least.
    followed : float
        Share of the horizon's frames with both boxes, at least.
    """

    observed: float = 1.0
    horizon: float = 3.0
    cover: float = 0.3
    apart: float = 0.05
    seen: float = 0.8
    followed: float = 0.6

    def __post_init__(self):
        require_number("observed", self.observed, above=0, unit="seconds")
        require_number("horizon", self.horizon, above=0, unit="seconds")
        for name in ("cover", "apart", "seen", "followed"):
            require_number(name, getattr(self, name), low=0, high=1)
        if self.apart > self.cover:
            raise ArgumentError(
                f"apart is {self.apart:g}, above cover, {self.cover:g}; a pair that occludes "
                "already cannot be foreseen. Pass a smaller apart."
            )


RULES = Rules()


@dataclass(frozen=True)
class Camera:
    """What is known of the camera that filmed the pairs."""

    frame_rate: float
    width: int
    height: int


@dataclass(frozen=True)
class Walkers:
    """What is seen of walkers up to a moment each; one row a walker and moment.

    Attributes
    ----------
    time : ndarray, shape (f,)
        Seconds, 0 at the moment.
    seen : ndarray of bool, shape (m, f)
        Where there is a box.
    x, feet, w, h : ndarray, shape (m, f)
        Centre column, row of the feet, width and height, pixels; anything where there
        is no box.
    horizon, rise : ndarray, shape (m,)
        Row of the horizon, and the drop of the feet below it as a multiple of the body's
        height, from all boxes of the recording up to the moment; rise is 0 where they do
        not show it.
    camera : Camera
    """

    time: np.ndarray
    seen: np.ndarray
    x: np.ndarray
    feet: np.ndarray
    w: np.ndarray
    h: np.ndarray
    horizon: np.ndarray
    rise: np.ndarray
    camera: Camera

    def __len__(self):
        return len(self.seen)


@dataclass(frozen=True)
class Pairs:
    """Pairs of walkers, what is seen of them, and what then happens.

    Attributes
    ----------
    name : str
        The recording's.
    walkers : Walkers
    who : ndarray of int, shape (n, 2)
        The two walkers of each pair: rows of `walkers`.
    track, now : ndarray of int, shape (n, 2)
        Rows and columns of the recording's stack: which track, and its frame.
    people : ndarray of str, shape (n, 2)
        Whose tracks they are.
    frame : ndarray of int, shape (n,)
        The moment, a frame number of the first walker's track.
    occludes : ndarray of bool, shape (n,)
        Whether they do within the horizon.
    seconds : ndarray, shape (n,)
        When; 0 where they do not.
    x, y : ndarray, shape (n,)
        Where, pixels; 0 where they do not.
    rules : Rules
    """

    name: str
    walkers: Walkers
    who: np.ndarray
    track: np.ndarray
    now: np.ndarray
    people: np.ndarray
    frame: np.ndarray
    occludes: np.ndarray
    seconds: np.ndarray
    x: np.ndarray
    y: np.ndarray
    rules: Rules = field(default=RULES)

    def __len__(self):
        return len(self.who)

    @cached_property
    def body(self):
        """Pixels of a body's height at the pair: the mean of the two boxes now, (n,)."""
        return self.walkers.h[:, -1][self.who].mean(axis=1)


def cover_of(first, second):
    """The intersection of boxes as a share of the smaller box.

    Parameters
    ----------
    first, second : tuple of array_like
        ``x, y, w, h`` that broadcast: left, top, width, height, pixels.

    Returns
    -------
    ndarray
        Between 0 and 1.
    """
    across, down = _overlap(first, second)
    smaller = np.minimum(first[2] * first[3], second[2] * second[3])
    return np.maximum(across, 0) * np.maximum(down, 0) / smaller


def _overlap(first, second):
    """How far two boxes reach into each other across and down, pixels; negative if apart."""
    (x, y, w, h), (u, v, a, b) = first, second
    return (
        np.minimum(x + w, u + a) - np.maximum(x, u),
        np.minimum(y + h, v + b) - np.maximum(y, v),
    )


def find_pairs(recording, *, rules=RULES):
    """Every pair at every whole second of a recording.

    Parameters
    ----------
    recording : Recording
        Tracks of one camera; frame numbers are its clock.
    rules : Rules, optional

    Returns
    -------
    Pairs
        In order of time, and then of the tracks.

    Raises
    ------
    DatasetError
        When there is no pair.
    """
    stack = recording.stack
    second = round(recording.frame_rate)
    begin, end = int(stack.start.min()), int((stack.start + stack.length).max())
    look = _Look.of(recording, rules)
    firsts, seconds, nows = [], [], []
    for frame in range(begin + look.frames - 1, end - 1, second):
        here = np.flatnonzero(look.observed(np.arange(len(stack.start)), frame - stack.start))
        i, j = np.triu_indices(len(here), 1)
        firsts.append(here[i])
        seconds.append(here[j])
        nows.append(np.full(len(i), frame))
    track = np.stack([_joined(firsts), _joined(seconds)], axis=1)
    now = _joined(nows)[:, None] - stack.start[track]
    return _judge(recording, look, track, now, _horizons_until, rules)


def lay_over(recording, *, shifts, rules=RULES):
    """Every pair in composites of two walks, by different people, of one recording.

    Parameters
    ----------
    recording : Recording
        One walk a sequence; their frame numbers need not be one clock.
    shifts : sequence of int
        Frames by which the second walk begins later.
    rules : Rules, optional

    Returns
    -------
    Pairs
        Mirrored copies are laid over other walks too, but not over their own.

    Raises
    ------
    DatasetError
        When no composite holds a pair.
    ArgumentError
        When a shift is not a whole number of at least 0.
    """
    shifts = [require_count("shifts", shift) for shift in shifts]
    stack = recording.stack
    second = round(recording.frame_rate)
    look = _Look.of(recording, rules)
    subject = recording.subjects.to_numpy()
    # In a composite without a shift the order says nothing.
    either = np.stack(np.nonzero(subject[:, None] != subject), axis=1)
    tracks, nows = [], []
    for shift in sorted(set(shifts)):
        pairs = either if shift else either[either[:, 0] < either[:, 1]]
        for frame in range(look.frames - 1, stack.valid.shape[1] + shift, second):
            now = np.array([frame, frame - shift])
            fit = look.observed(pairs[:, 0], now[0]) & look.observed(pairs[:, 1], now[1])
            tracks.append(pairs[fit])
            nows.append(np.tile(now, (fit.sum(), 1)))
    track, now = _joined(tracks).reshape(-1, 2), _joined(nows).reshape(-1, 2)
    return _judge(recording, look, track, now, _no_horizon, rules)


def _joined(parts):
    return np.concatenate(parts) if parts else np.empty(0, dtype=int)


@dataclass(frozen=True)
class _Look:
    """Tracks laid side by side, with room before and after for windows that overhang."""

    valid: np.ndarray
    boxes: tuple  # x, y, w, h, like `valid`
    room: int
    frames: int  # of the observed time
    ahead: int  # of the horizon
    half: int
    rules: Rules

    @classmethod
    def of(cls, recording, rules):
        rate, stack = recording.frame_rate, recording.stack
        frames, ahead = max(2, round(rate * rules.observed)), max(1, round(rate * rules.horizon))
        room = max(frames, ahead)
        beside = ((0, 0), (room, room))
        return cls(
            np.pad(stack.valid, beside),
            tuple(np.pad(stack.curves[name], beside) for name in (X, Y, W, H)),
            room,
            frames,
            ahead,
            frames // 2,
            rules,
        )

    def at(self, track, now, offsets):
        """Validity and boxes at `now` + `offsets`; outside a track nothing is valid."""
        column = now[..., None] + offsets + self.room
        column = np.clip(column, 0, self.valid.shape[1] - 1)
        track = track[..., None]
        return self.valid[track, column], tuple(box[track, column] for box in self.boxes)

    def observed(self, track, now):
        """Which walkers are boxed well enough in the time before the moment."""
        now = np.broadcast_to(now, np.shape(track))
        inside = (now >= 0) & (now < self.valid.shape[1] - 2 * self.room)
        valid = self.valid[
            np.asarray(track)[:, None],
            np.where(inside, now, 0)[:, None] + np.arange(1 - self.frames, 1) + self.room,
        ]
        enough = valid.sum(axis=1) >= self.rules.seen * self.frames - 1e-9
        ends = valid[:, -1] & valid[:, 0] & valid[:, -1 - self.half]
        return inside & enough & ends


def _judge(recording, look, track, now, horizons, rules):
    """Keep the pairs that can be judged, and see what happens to them."""
    keep = np.zeros(len(track), bool)
    later = np.zeros(len(track), int)
    x, y = np.zeros(len(track)), np.zeros(len(track))
    offsets = np.arange(look.ahead + 1)
    for start in range(0, len(track), CHUNK):
        at = slice(start, start + CHUNK)
        valid, boxes = look.at(track[at], now[at], offsets)
        both = valid.all(axis=1)
        first, second = ([box[:, one] for box in boxes] for one in (0, 1))
        across, down = _overlap(first, second)
        smaller = np.minimum(first[2] * first[3], second[2] * second[3])
        covered = np.maximum(across, 0) * np.maximum(down, 0)
        hit = (covered > rules.cover * smaller) & both
        followed = both[:, 1:].sum(axis=1) >= rules.followed * look.ahead - 1e-9
        keep[at] = followed & (covered[:, 0] <= rules.apart * smaller[:, 0])
        when = np.where(hit[:, 1:].any(axis=1), hit[:, 1:].argmax(axis=1) + 1, 0)
        row = np.arange(len(when))
        left, top = (np.maximum(first[k], second[k])[row, when] for k in (0, 1))
        later[at] = when
        x[at] = left + across[row, when] / 2
        y[at] = top + down[row, when] / 2
    if not keep.any():
        raise DatasetError(
            f"{recording.name} holds no pair of walkers that are apart and followed for "
            f"{rules.horizon:g} s; pass a longer recording or other rules."
        )
    track, now, later, x, y = track[keep], now[keep], later[keep], x[keep], y[keep]
    places = np.unique(np.r_[track * look.valid.shape[1] + now], return_inverse=True)
    moment = np.stack(np.divmod(places[0], look.valid.shape[1]), axis=1)
    occludes = later > 0
    return Pairs(
        name=recording.name,
        walkers=_watch(recording, look, moment, horizons),
        who=places[1].reshape(-1, 2),
        track=track,
        now=now,
        people=recording.subjects.to_numpy(object).astype(str)[track],
        frame=recording.stack.start[track[:, 0]] + now[:, 0],
        occludes=occludes,
        seconds=later / recording.frame_rate,
        x=np.where(occludes, x, 0.0),
        y=np.where(occludes, y, 0.0),
        rules=rules,
    )


def _watch(recording, look, moment, horizons):
    offsets = np.arange(1 - look.frames, 1)
    seen, (x, y, w, h) = look.at(moment[:, 0], moment[:, 1], offsets)
    horizon, rise = horizons(recording, recording.stack.start[moment[:, 0]] + moment[:, 1])
    camera = Camera(recording.frame_rate, recording.frame_width, recording.frame_height)
    time = offsets / recording.frame_rate
    return Walkers(time, seen, x + w / 2, y + h, w, h, horizon, rise, camera)


def _no_horizon(_recording, frame):
    """Walks laid over each other were filmed by cameras that need not be one."""
    return np.zeros(len(frame)), np.zeros(len(frame))


def _horizons_until(recording, frame):
    """The horizon that the boxes up to each frame show; see `perspective.estimate_camera`."""
    boxes = recording.boxes
    clock = boxes["frame"].to_numpy()
    order = np.argsort(clock, kind="stable")
    clock = clock[order]
    height = boxes[H].to_numpy(float)[order]
    feet = boxes[Y].to_numpy(float)[order] + height
    horizon, rise = np.zeros(len(frame)), np.zeros(len(frame))
    for moment in np.unique(frame):
        count = np.searchsorted(clock, moment, side="right")
        some = np.linspace(0, count - 1, min(count, HORIZON_BOXES)).astype(int)
        low, high = np.percentile(height[some], [5, 95])
        if high < DEPTH_RANGE * low or np.ptp(feet[some]) == 0:
            continue
        line, _ = fit_lines_robust(feet[some], height[some])
        if line.slope > 0:
            now = frame == moment
            horizon[now], rise[now] = -line.intercept / line.slope, 1 / line.slope
    return horizon, rise
