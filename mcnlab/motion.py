"""How walkers whom a camera saw for a second will move on: boxes to come.

*Straight in the image*: box centre, feet and height go on as lines through the last second.

*Straight on the ground*: for a pinhole camera, 1/s and x/s of a straight walk are linear in
time, s being the pixels a body height (`mcnlab.perspective`).  Going back to the image needs
neither the focal length nor the principal point, as they cancel.  Where the walkers show the
horizon, s is read from the feet too.  Velocities fade, a box that hardly moves may as well
stand, and where somebody will be is uncertain by more every second.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mcnlab.lines import fit_lines

SLOWEST = 0.25  # share of a scale to which it may shrink or grow within the horizon

# How people walk on, as shares of a body height; set on the four recordings of MOTChallenge
# named in the notebook, and forgiving: halving or doubling any moves F1 by 0.02 at most.
RECENT = 0.3  # s, in which what was seen loses half of its weight
PERSISTENCE = 10.0  # s, after which a velocity has faded to 1/e
JITTER = 0.08  # body heights a second: a box that moves as slowly may as well stand
BOX_NOISE = 0.02  # of a box's place
DRIFT = 0.05  # of the place, more every second, of somebody who stands
WANDER = 0.2  # the same, more for every body height a second


class Motion(NamedTuple):
    """Boxes of walkers to come, pixels; shape (m, k), one column a time."""

    x: np.ndarray  # centre column
    feet: np.ndarray  # row of the feet
    w: np.ndarray
    h: np.ndarray

    def take(self, rows):
        """The walkers `rows`."""
        return Motion(*(value[rows] for value in self))


def move_straight(walkers, times):
    """The walkers' boxes at `times` seconds from now, on straight lines in the image."""
    weights = walkers.seen.astype(float)
    x, feet, h = (
        fit_lines(walkers.time, value, weights=weights)
        for value in (walkers.x, walkers.feet, walkers.h)
    )
    height = np.maximum(h.intercept[:, None] + h.slope[:, None] * times, 1.0)
    low = SLOWEST * h.intercept[:, None]
    height = np.maximum(height, low)
    seen_h = np.where(walkers.seen, walkers.h, 1.0)
    aspect = (weights * walkers.w / seen_h).sum(axis=1) / weights.sum(axis=1)
    return Motion(
        x.intercept[:, None] + x.slope[:, None] * times,
        feet.intercept[:, None] + feet.slope[:, None] * times,
        aspect[:, None] * height,
        height,
    )


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
    """

    walkers: object
    near: np.ndarray
    near_rate: np.ndarray
    side: np.ndarray
    side_rate: np.ndarray
    fill: np.ndarray
    aspect: np.ndarray
    feet: np.ndarray
    feet_rate: np.ndarray

    @classmethod
    def of(cls, walkers):
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
        total = weights.sum(axis=1)
        fill = (weights * height / scale).sum(axis=1) / total
        aspect = (weights * walkers.w / height).sum(axis=1) / total
        return cls(
            walkers,
            *(near.intercept, near.slope, side.intercept, side.slope),
            *(fill, aspect, feet.intercept, feet.slope),
        )

    @cached_property
    def rate(self):
        """Velocity in the image, body heights a second to the right and down, each (m,)."""
        height = self.fill / self.near
        across = (self.side_rate - self.side / self.near * self.near_rate) / self.near
        return across / height, self.feet_rate / height

    @property
    def pace(self):
        """Speed in the image, body heights a second, (m,)."""
        return np.hypot(*self.rate)

    def move(self, times):
        """The walkers' boxes at `times` seconds from now."""
        walkers = self.walkers
        square = self.pace**2
        fading = PERSISTENCE * -np.expm1(-times / PERSISTENCE)
        lasting = (square / (square + JITTER**2))[:, None] * fading
        near = self.near[:, None] + self.near_rate[:, None] * lasting
        scale = 1 / np.maximum(near, SLOWEST * self.near[:, None])
        x = (self.side[:, None] + self.side_rate[:, None] * lasting) * scale
        h = self.fill[:, None] * scale
        # The feet keep their drop below the horizon, in body heights; without a horizon
        # they go on as they did.
        drop = (self.feet - walkers.horizon) * self.near
        feet = np.where(
            walkers.rise[:, None] > 0,
            walkers.horizon[:, None] + drop[:, None] * scale,
            self.feet[:, None] + self.feet_rate[:, None] * lasting,
        )
        return Motion(x, feet, self.aspect[:, None] * h, h)

    def spread(self, times):
        """Standard deviation of the place across at `times`, pixels, shape (m, k)."""
        wander = DRIFT**2 + (WANDER * self.pace) ** 2
        height = self.fill / self.near
        return np.sqrt(BOX_NOISE**2 + wander[:, None] * times**2) * height[:, None]

    def heading(self, *, focal_length):
        """The heading, degrees clockwise from away along the camera's axis, (m,)."""
        middle = (self.walkers.camera.width - 1) / 2
        across = self.side_rate - middle * self.near_rate
        return np.degrees(np.arctan2(across, focal_length * self.near_rate)) % 360
