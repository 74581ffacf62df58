"""How walkers whom a camera saw for a second will move on: boxes to come.

*Straight in the image*: box centre, feet and height go on as lines through the last second.

*Straight on the ground*: for a pinhole camera, 1/s and x/s of a straight walk are linear in
time, s being the pixels a body height (`mcnlab.walking.heading`).  Going back to the image needs
neither the focal length nor the principal point, as they cancel.  Where the walkers show the
horizon, s is read from the feet too.  Velocities fade, a box that hardly moves may as well
stand, and where somebody will be is uncertain by more every second.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import require_number
from mcnlab.errors import ArgumentError
from mcnlab.occlusion.pairs import Walkers
from mcnlab.regression import fit_lines

SLOWEST = 0.25  # share of a height (image) or a distance (ground) that is left at least
# How people walk on, as shares of a body height; set while looking at the recordings named in
# the notebook.  Halving or doubling one of them moves the mean F1 of "learned" by 0.011 at
# most, and nearly always down; that of a single recording by up to 0.04.
RECENT = 0.3  # s, in which what was seen loses half of its weight
PERSISTENCE = 10.0  # s, after which a velocity has faded to 1/e
JITTER = 0.08  # body heights a second: a box that moves or grows as slowly may as well stand
BOX_NOISE = 0.02  # of a box's place
DRIFT = 0.05  # of the place, more every second, of somebody who stands
WANDER = 0.2  # the same, more for every body height a second


class Motion(NamedTuple):
    """Boxes of walkers to come, pixels; shape (k, m), one row a time, one column a walker."""

    x: np.ndarray  # centre column
    feet: np.ndarray  # row of the feet
    w: np.ndarray
    h: np.ndarray

    def take(self, walkers: np.ndarray) -> "Motion":
        """The boxes of some walkers, by number."""
        return Motion(*(value[:, walkers] for value in self))


def move_straight(walkers: Walkers, times: ArrayLike) -> Motion:
    """The walkers' boxes in some seconds, on straight lines in the image.

    Parameters
    ----------
    walkers : pairs.Walkers
    times : array_like, shape (k,)
        Seconds from now.

    Returns
    -------
    Motion

    Raises
    ------
    ArgumentError
        When a time is not finite.
    """
    times = _column(times)
    weights = walkers.seen.astype(float)
    x, feet, h = (
        fit_lines(walkers.time, value, weights=weights)
        for value in (walkers.x, walkers.feet, walkers.h)
    )
    # Nobody shrinks to nothing, nor does the line through a box that jumps in size.
    now = np.maximum(h.intercept, SLOWEST * walkers.h[:, -1])
    height = np.maximum(now + h.slope * times, SLOWEST * now)
    seen_h = np.where(walkers.seen, walkers.h, 1.0)
    aspect = (weights * walkers.w / seen_h).sum(axis=1) / weights.sum(axis=1)
    return Motion(
        x.intercept + x.slope * times,
        feet.intercept + feet.slope * times,
        aspect * height,
        height,
    )


def _column(times):
    """Times as a column, to broadcast over walkers."""
    times = np.atleast_1d(np.asarray(times, dtype=float))
    if times.ndim != 1 or not np.isfinite(times).all():
        raise ArgumentError(f"times is {times}; pass finite seconds, shape (k,).")
    return times[:, None]


@dataclass(frozen=True)
class Ground:
    """Where walkers are on the ground and how they move there, by the last second.

    Attributes
    ----------
    walkers : pairs.Walkers
    near, near_rate : ndarray, shape (m,)
        1/s, with s the pixels a body height, and its change a second.
    side, side_rate : ndarray, shape (m,)
        x/s, and its change a second.
    fill, aspect : ndarray, shape (m,)
        Box height over s, and box width over box height.
    feet, feet_rate : ndarray, shape (m,)
        Row of the feet, and its change a second, pixels.
    doubt : ndarray, shape (3, m)
        Variances of a fitted line's value now, of its slope, and their covariance, where each
        box errs with variance 1.
    """

    walkers: Walkers
    near: np.ndarray
    near_rate: np.ndarray
    side: np.ndarray
    side_rate: np.ndarray
    fill: np.ndarray
    aspect: np.ndarray
    feet: np.ndarray
    feet_rate: np.ndarray
    doubt: np.ndarray

    @classmethod
    def of(cls, walkers: Walkers) -> "Ground":
        """Fit lines through what was seen of each walker, the latest counting most."""
        seen, rise = walkers.seen, walkers.rise[:, None]
        height = np.where(seen, walkers.h, 1.0)
        scale = (height + rise * (walkers.feet - walkers.horizon[:, None])) / (1 + rise**2)
        # Feet at or above the horizon say nothing of the distance.
        scale = np.where(scale > 0.1 * height, scale, height)
        weights = seen * np.exp2(walkers.time / RECENT)
        near = fit_lines(walkers.time, 1 / scale, weights=weights)
        side = fit_lines(walkers.time, walkers.x / scale, weights=weights)
        feet = fit_lines(walkers.time, walkers.feet, weights=weights)
        # The line through a box that jumps in size may end at a distance below 0; then the
        # last box has to do.
        last = 1 / scale[:, -1]
        sound = near.intercept >= SLOWEST * last
        now = np.where(sound, near.intercept, last)
        beside = np.where(sound, side.intercept, walkers.x[:, -1] * last)
        total = weights.sum(axis=1)
        fill = (weights * height / scale).sum(axis=1) / total
        aspect = (weights * walkers.w / height).sum(axis=1) / total
        return cls(
            walkers,
            *(now, near.slope, beside, side.slope),
            *(fill, aspect, feet.intercept, feet.slope, _doubt_of(walkers.time, weights)),
        )

    @cached_property
    def rate(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocity in the image, body heights a second to the right and down, each (m,)."""
        height = self.fill / self.near
        across = (self.side_rate - self.side / self.near * self.near_rate) / self.near
        return across / height, self.feet_rate / height

    @property
    def pace(self) -> np.ndarray:
        """Speed in the image, body heights a second, (m,)."""
        return np.hypot(*self.rate)

    def move(self, times: ArrayLike) -> Motion:
        """The walkers' boxes in some seconds; as `move_straight`, but straight on the ground."""
        # Who walks straight at the camera hardly moves in the image, but grows.
        walkers, square = self.walkers, self.pace**2 + (self.near_rate / self.near) ** 2
        times = _column(times)
        fading = PERSISTENCE * -np.expm1(-times / PERSISTENCE)
        lasting = square / (square + JITTER**2) * fading
        # Who comes too near is let go no farther: the column, too, is that of this moment.
        coming = np.minimum(self.near_rate, 0.0)
        nearest = (1 - SLOWEST) * self.near
        lasting = np.where(
            -coming * lasting > nearest, nearest / np.where(coming, -coming, 1.0), lasting
        )
        scale = 1 / (self.near + self.near_rate * lasting)
        x = (self.side + self.side_rate * lasting) * scale
        h = self.fill * scale
        # The feet keep their drop below the horizon, in body heights; without a horizon
        # they go on as they did.
        drop = (self.feet - walkers.horizon) * self.near
        feet = np.where(
            walkers.rise > 0,
            walkers.horizon + drop * scale,
            self.feet + self.feet_rate * lasting,
        )
        return Motion(x, feet, self.aspect * h, h)

    def spread(self, times: ArrayLike) -> np.ndarray:
        """Standard deviation of the place across at `times`, pixels, shape (k, m)."""
        times = _column(times)
        now, rate, both = self.doubt
        # The box to come errs, and so do those that the line was fitted through.
        boxes = BOX_NOISE**2 * (1 + now + 2 * both * times + rate * times**2)
        wander = (DRIFT**2 + (WANDER * self.pace) ** 2) * times**2
        return np.sqrt(boxes + wander) * (self.fill / self.near)

    def heading(self, *, focal_length: float) -> np.ndarray:
        """The heading, degrees clockwise from away along the camera's axis, (m,).

        Of somebody who stands it says nothing.  The camera is taken to look level; looking
        down by 20° costs a few degrees.
        """
        require_number("focal_length", focal_length, above=0, unit="pixels")
        middle = (self.walkers.camera.width - 1) / 2  # pixels count from the centre of the first
        across = self.side_rate - middle * self.near_rate
        return np.degrees(np.arctan2(across, focal_length * self.near_rate)) % 360


def _doubt_of(time, weights):
    """How a box's own noise passes into a weighted line: variances of its value at 0, of its
    slope, and their covariance, (3, m), for noise of variance 1 in each frame."""
    powers = np.stack([np.ones_like(time), time, time**2])
    s0, s1, s2 = powers @ weights.T
    q0, q1, q2 = powers @ (weights**2).T
    square = (s0 * s2 - s1**2) ** 2
    return (
        np.stack(
            [
                s2**2 * q0 - 2 * s1 * s2 * q1 + s1**2 * q2,
                s1**2 * q0 - 2 * s0 * s1 * q1 + s0**2 * q2,
                (s0 * s2 + s1**2) * q1 - s1 * s2 * q0 - s0 * s1 * q2,
            ]
        )
        / square
    )
