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

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcnlab.cameras.horizon import horizons_until
from mcnlab.checks import require_count, require_number
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.occlusion.truth import COVER, Truth, find_occlusions
from mcnlab.tables import FRAME, SEQUENCE, SUBJECT, H, W, X, Y

CHUNK = 4096  # pairs whose futures are laid out at once


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

    Raises
    ------
    ArgumentError
        When a time is not positive, a share is not one, or `apart` is above `cover`.
    """

    observed: float = 1.0
    horizon: float = 3.0
    cover: float = COVER
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
class Film:
    """What is known of the film that shows the pairs: frames a second, and pixels."""

    frame_rate: float
    width: int
    height: int


@dataclass(frozen=True)
class Walkers:
    """What is seen of walkers up to a moment each; one row a walker and moment.

    Attributes
    ----------
    time : ndarray, shape (f,)
        Seconds, rising to 0 at the moment.
    seen : ndarray of bool, shape (m, f)
        Where there is a box.
    x, feet, w, h : ndarray, shape (m, f)
        Centre column, row of the lower edge, width and height, pixels, as `mcnlab.tables`
        counts them: the lower edge is half a pixel below the last row, x + (w − 1)/2 and
        y + h − ½ of a box; anything where there is no box.
    horizon, rise : ndarray, shape (m,)
        Row of the horizon, and the drop of the feet below it as a multiple of the body's
        height, from all boxes of the recording up to the moment; rise is 0 where they do
        not show it.
    camera : Film
    """

    time: np.ndarray
    seen: np.ndarray
    x: np.ndarray
    feet: np.ndarray
    w: np.ndarray
    h: np.ndarray
    horizon: np.ndarray
    rise: np.ndarray
    camera: Film

    def __len__(self):
        return len(self.seen)


@dataclass(frozen=True, kw_only=True)
class WatchedPairs:
    """Pairs of walkers at a moment, with nothing known of what comes.

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
        The moment, as a frame number of the first walker's track.
    rules : Rules
    """

    name: str
    walkers: Walkers
    who: np.ndarray
    track: np.ndarray
    now: np.ndarray
    people: np.ndarray
    frame: np.ndarray
    rules: Rules = RULES

    def __len__(self):
        return len(self.who)

    @cached_property
    def body(self) -> np.ndarray:
        """Pixels of a body's height at the pair: the mean of the two boxes now, (n,)."""
        return self.walkers.h[:, -1][self.who].mean(axis=1)


@dataclass(frozen=True, kw_only=True)
class Pairs(WatchedPairs):
    """Pairs of walkers, and what then happens.

    Attributes
    ----------
    occludes : ndarray of bool, shape (n,)
        Whether they do within the horizon.
    seconds : ndarray, shape (n,)
        When, after the moment; 0 where they do not.
    x, y : ndarray, shape (n,)
        Where: the middle of the intersection, pixels; 0 where they do not.
    """

    occludes: np.ndarray
    seconds: np.ndarray
    x: np.ndarray
    y: np.ndarray


def find_pairs(recording: Recording, *, rules: Rules = RULES) -> Pairs:
    """Every pair at every whole second of a recording.

    Parameters
    ----------
    recording : Recording
        Tracks of one camera; frame numbers are its clock, and each track is another person.
        A second is the nearest whole number of frames, at least one.
    rules : Rules, optional

    Returns
    -------
    Pairs
        In order of time, and then of the tracks.

    Raises
    ------
    DatasetError
        When there is no pair, or the frame rate is too low for the rules.

    Examples
    --------
    >>> from mcnlab import occlusion, synthetic
    >>> square = synthetic.make_crossings(people=12, seconds=12)
    >>> pairs = occlusion.find_pairs(square)
    >>> len(pairs.frame), int(pairs.occludes.sum())
    (141, 34)
    """
    stack = recording.stack
    look = _Look.of(recording, rules)
    # Only frames with boxes hold pairs, and there may be years between two tracks.
    clock = np.unique(recording.boxes[FRAME].to_numpy(np.int64))
    since = clock - clock[0] - (look.frames - 1)
    firsts, seconds, nows = [], [], []
    for frame in clock[(since >= 0) & (since % look.second == 0)]:
        here = np.flatnonzero(look.observed(np.arange(len(stack.start)), frame - stack.start))
        i, j = np.triu_indices(len(here), 1)
        firsts.append(here[i])
        seconds.append(here[j])
        nows.append(np.full(len(i), frame))
    track = np.stack([_joined(firsts), _joined(seconds)], axis=1)
    now = _joined(nows)[:, None] - stack.start[track]
    return _judge(recording, look, track, now, horizons_until, rules)


def watch(recording: Recording, frame: int, *, rules: Rules = RULES) -> WatchedPairs:
    """Every pair at one frame, to forecast what is not filmed yet.

    Parameters
    ----------
    recording : Recording
        As for `find_pairs`; what comes after the frame is not looked at.
    frame : int
    rules : Rules, optional
        How long is observed, and how well; pairs that cover each other already are given too.

    Returns
    -------
    WatchedPairs

    Raises
    ------
    DatasetError
        When fewer than two walkers were boxed for the observed time before the frame.

    Examples
    --------
    >>> from mcnlab import occlusion, synthetic
    >>> square = synthetic.make_crossings(people=12, seconds=12)
    >>> now = occlusion.watch(square, 100)
    >>> now.people[:2].tolist()
    [['p001', 'p002'], ['p001', 'p004']]
    """
    frame = require_count("frame", frame)
    stack = recording.stack
    look = _Look.of(recording, rules)
    here = np.flatnonzero(look.observed(np.arange(len(stack.start)), frame - stack.start))
    if len(here) < 2:
        raise DatasetError(
            f"{recording.name} shows {len(here)} walker(s) at frame {frame} who were boxed for "
            f"{rules.observed:g} s; an occlusion takes two. Pass another frame."
        )
    track = here[np.stack(np.triu_indices(len(here), 1), axis=1)]
    now = frame - stack.start[track]
    return WatchedPairs(**_see(recording, look, track, now, horizons_until, rules))


def lay_over(recording: Recording, *, shifts: Sequence[int], rules: Rules = RULES) -> Pairs:
    """Every pair in composites of two walks, by different people, of one recording.

    Parameters
    ----------
    recording : Recording
        One walk a sequence; their frame numbers need not be one clock.
    shifts : sequence of int
        Frames by which the second walk begins later; at 0, two walks make one composite,
        otherwise two.
    rules : Rules, optional

    Returns
    -------
    Pairs
        In order of shift and time.  Mirrored copies are laid over other people's walks too,
        but not over those of their own subject.  Where there is one subject only, his walks
        are laid over each other, each as another person.

    Raises
    ------
    DatasetError
        When no composite holds a pair, or the frame rate is too low for the rules.
    ArgumentError
        When a shift is not a whole number of at least 0, or there is none.
    """
    listed = list(shifts) if np.iterable(shifts) else [shifts]
    shifts = [require_count("shifts", shift) for shift in listed]
    if not shifts:
        raise ArgumentError("shifts is empty; pass at least one number of frames.")
    longest = recording.stack.valid.shape[1]
    look = _Look.of(recording, rules)
    subject = recording.subjects.to_numpy()
    if len(set(subject)) == 1:
        recording = _each_his_own(recording)
        subject = recording.subjects.to_numpy()
    # In a composite without a shift the order says nothing.
    either = np.stack(np.nonzero(subject[:, None] != subject), axis=1)
    tracks, nows = [], []
    for shift in sorted(set(shifts)):
        pairs = either if shift else either[either[:, 0] < either[:, 1]]
        for frame in range(look.frames - 1, longest, look.second):
            now = np.array([frame, frame - shift])
            fit = look.observed(pairs[:, 0], now[0]) & look.observed(pairs[:, 1], now[1])
            tracks.append(pairs[fit])
            nows.append(np.tile(now, (fit.sum(), 1)))
    track, now = _joined(tracks).reshape(-1, 2), _joined(nows).reshape(-1, 2)
    return _judge(recording, look, track, now, _no_horizon, rules)


def _each_his_own(recording):
    """The recording with another subject in each walk."""
    boxes = recording.boxes
    return recording.with_boxes(boxes.assign(**{SUBJECT: boxes[SEQUENCE]}))


def _joined(parts):
    return np.concatenate(parts) if parts else np.empty(0, dtype=int)


@dataclass(frozen=True)
class _Look:
    """Tracks laid side by side, with room before and after for windows that overhang."""

    valid: np.ndarray
    boxes: tuple  # x, y, w, h, like `valid`
    room: int
    second: int  # frames
    frames: int  # of the observed time
    half: int  # of those, from the middle one to the moment
    ahead: int  # of the horizon, as far as any track can last
    wanted: float  # of the horizon, with both boxes
    rules: Rules

    @classmethod
    def of(cls, recording, rules):
        rate, stack = recording.frame_rate, recording.stack
        shortest = min(rules.observed, rules.horizon)
        if rate * shortest < 0.5:
            raise DatasetError(
                f"{recording.name} has {rate:g} frames a second, hardly one in {shortest:g} s; "
                "pass rules that look longer."
            )
        frames, ahead = max(2, round(rate * rules.observed)), max(1, round(rate * rules.horizon))
        longest = stack.valid.shape[1]
        if frames > longest:
            raise _no_pair(recording, rules)
        wanted = rules.followed * ahead - 1e-9
        ahead = min(ahead, longest)
        room = max(frames, ahead)
        beside = ((0, 0), (room, room))
        return cls(
            np.pad(stack.valid, beside),
            tuple(np.pad(stack.curves[name], beside) for name in (X, Y, W, H)),
            room,
            max(1, round(rate)),
            frames,
            frames // 2,
            ahead,
            wanted,
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
    kept, parts = [np.zeros(0, bool)], []
    for start in range(0, len(track), CHUNK):
        keep, truth = _fate(look, track[start : start + CHUNK], now[start : start + CHUNK], rules)
        kept.append(keep)
        parts.append(truth)
    keep = np.concatenate(kept)
    if not keep.any():
        raise _no_pair(recording, rules)
    truth = Truth(*(np.concatenate(values)[keep] for values in zip(*parts, strict=True)))
    return Pairs(
        **_see(recording, look, track[keep], now[keep], horizons, rules),
        occludes=truth.occludes,
        seconds=truth.frame / recording.frame_rate,
        x=np.where(truth.occludes, truth.x, 0.0),
        y=np.where(truth.occludes, truth.y, 0.0),
    )


def _fate(look, track, now, rules):
    """Which pairs can be judged, and what becomes of all of them."""
    valid, boxes = look.at(track, now, np.arange(look.ahead + 1))
    both = valid.all(axis=1)
    first, second = ([box[:, one] for box in boxes] for one in (0, 1))
    truth = find_occlusions(first, second, both, cover=rules.cover)
    followed = both[:, 1:].sum(axis=1) >= look.wanted
    return followed & (truth.now <= rules.apart), truth


def _see(recording, look, track, now, horizons, rules):
    """The fields of a `WatchedPairs`."""
    # Each walker and moment once, however many pairs it is in.
    places = np.unique(track * look.valid.shape[1] + now, return_inverse=True)
    moment = np.stack(np.divmod(places[0], look.valid.shape[1]), axis=1)
    return {
        "name": recording.name,
        "walkers": _walkers_at(recording, look, moment, horizons),
        "who": places[1].reshape(-1, 2),
        "track": track,
        "now": now,
        "people": recording.subjects.to_numpy(object).astype(str)[track],
        "frame": recording.stack.start[track[:, 0]] + now[:, 0],
        "rules": rules,
    }


def _no_pair(recording, rules):
    if len(recording.sequences) < 2:
        return DatasetError(
            f"{recording.name} holds one walker, {recording.sequences[0]!r}; an occlusion takes "
            "two. Pass a recording of more."
        )
    return DatasetError(
        f"{recording.name} holds no pair of walkers boxed for {rules.observed:g} s, apart, and "
        f"followed for {rules.horizon:g} s; pass a longer recording or other rules."
    )


def _walkers_at(recording, look, moment, horizons):
    """What is seen of walkers up to their moments; `moment` is (m, 2), track and column."""
    offsets = np.arange(1 - look.frames, 1)
    seen, (x, y, w, h) = look.at(moment[:, 0], moment[:, 1], offsets)
    horizon, rise = horizons(recording, recording.stack.start[moment[:, 0]] + moment[:, 1])
    camera = Film(recording.frame_rate, recording.frame_width, recording.frame_height)
    time = offsets / recording.frame_rate
    # Rows and columns count from the centre of the top-left pixel, half a pixel from its edge.
    middle, feet = x + (w - 1) / 2, y + h - 0.5
    horizon = np.where(rise > 0, horizon - 0.5, 0.0)
    return Walkers(time, seen, middle, feet, w, h, horizon, rise, camera)


def _no_horizon(_recording, frame):
    """None: walks laid over each other were filmed by cameras that need not be one."""
    return np.zeros(len(frame)), np.zeros(len(frame))
