"""The camera: where points of the world are seen, and what a pixel sees."""

import math
from dataclasses import dataclass, replace

import numpy as np

from mcnlab.checks import require_count, require_number, require_points
from mcnlab.errors import ArgumentError


@dataclass(frozen=True)
class View:
    """A pinhole camera above the ground, upright, without distortion.

    The defaults resemble the camera of CASIA Dataset A.

    Attributes
    ----------
    focal_length : float
        Pixels.
    height : float
        Metres above the ground.
    tilt : float
        Degrees below the horizontal.
    frame_width, frame_height : int
        Pixels; the optical axis meets the middle of the frame.
    """

    focal_length: float = 450.0
    height: float = 1.55
    tilt: float = 4.0
    frame_width: int = 352
    frame_height: int = 240

    def __post_init__(self):
        require_number("focal_length", self.focal_length, above=0, unit="pixels")
        require_number("height", self.height, above=0, unit="metres")
        require_number("tilt", self.tilt, low=-60, high=89, unit="degrees")
        require_count("frame_width", self.frame_width, low=1)
        require_count("frame_height", self.frame_height, low=1)

    @property
    def centre(self):
        """The principal point (x, y), pixels."""
        return (self.frame_width - 1) / 2, (self.frame_height - 1) / 2

    def project(self, points):
        """Where points of the world appear.

        Parameters
        ----------
        points : array_like, shape (..., 3)
            X, Y, Z in metres.

        Returns
        -------
        pixels : ndarray, shape (..., 2)
            x, y; without meaning where the depth is not positive.
        depth : ndarray, shape (...)
            Metres along the optical axis.
        """
        points = np.asarray(points, dtype=float)
        if points.ndim == 0 or points.shape[-1] != 3:
            raise ArgumentError(
                f"points has the shape {points.shape}; pass X, Y, Z along the last axis."
            )
        sine, cosine = math.sin(math.radians(self.tilt)), math.cos(math.radians(self.tilt))
        above = points[..., 1] - self.height
        depth = points[..., 2] * cosine - above * sine
        up = points[..., 2] * sine + above * cosine
        scale = self.focal_length / np.where(depth == 0, np.inf, depth)
        pixels = np.empty((*depth.shape, 2))
        pixels[..., 0] = self.centre[0] + scale * points[..., 0]
        pixels[..., 1] = self.centre[1] - scale * up
        return pixels, depth


@dataclass(frozen=True)
class TsaiCamera:
    """A camera in Tsai's model, as PETS 2009 publishes it.

    Attributes
    ----------
    focal : float
        Millimetres.
    kappa : float
        First-order radial distortion, 1/mm².
    centre : tuple of float
        Principal point x, y, pixels.
    aspect : float
        Uncertainty scale factor sx.
    pitch : tuple of float
        Effective pixel pitch dpx, dpy, mm.
    turn : ndarray, shape (3, 3)
        World to camera.
    shift : ndarray, shape (3,)
        Millimetres.
    """

    focal: float
    kappa: float
    centre: tuple
    aspect: float
    pitch: tuple
    turn: np.ndarray
    shift: np.ndarray

    @property
    def place(self):
        """Where the camera stands, world metres, shape (3,)."""
        return place_of(self.turn, self.shift)

    def to_ground(self, pixels):
        """Where the rays through pixels meet the ground.

        Parameters
        ----------
        pixels : array_like, shape (n, 2)
            x, y in the image the camera was calibrated on.

        Returns
        -------
        ndarray, shape (n, 2)
            World metres.

        Raises
        ------
        ArgumentError
            When a ray runs above the horizon.
        """
        pixels = require_points("pixels", pixels)
        u = (pixels[:, 0] - self.centre[0]) * self.pitch[0] / self.aspect
        v = (pixels[:, 1] - self.centre[1]) * self.pitch[1]
        swell = 1.0 + self.kappa * (u**2 + v**2)
        rays = np.stack([u * swell, v * swell, np.full(len(u), self.focal)], axis=1) @ self.turn
        origin = -self.turn.T @ self.shift
        falling = rays[:, 2] * origin[2] < 0
        if not falling.all():
            raise ArgumentError(
                f"pixels: {np.count_nonzero(~falling)} lie on or above the horizon and see no "
                "ground; drop them."
            )
        reach = -origin[2] / rays[:, 2]
        return (origin[:2] + reach[:, None] * rays[:, :2]) / 1000.0

    def to_image(self, points):
        """Where points in the world are seen.

        Parameters
        ----------
        points : array_like, shape (n, 2) or (n, 3)
            World metres; on the ground if two.

        Returns
        -------
        ndarray, shape (n, 2)
            Pixels.

        Raises
        ------
        ArgumentError
            When a point is not finite or not in front of the camera, or lies so far out
            that the distortion model folds over.
        """
        points = _check_world(points)
        seen = (1000.0 * points) @ self.turn.T + self.shift
        if (seen[:, 2] <= 0).any():
            row = int(np.flatnonzero(seen[:, 2] <= 0)[0])
            raise ArgumentError(f"points row {row} lies behind the camera; drop it.")
        ideal = self.focal * seen[:, :2] / seen[:, 2:]
        straight = np.hypot(ideal[:, 0], ideal[:, 1])
        # The calibration gives the ideal radius from the seen one, r + κr³; Newton's steps
        # from the ideal radius undo it, and settle in a few where the model is sound.
        radius = straight.copy()
        for _ in range(20):
            slope = 1.0 + 3.0 * self.kappa * radius**2
            if (slope <= 0.1).any():
                row = int(np.flatnonzero(slope <= 0.1)[0])
                raise ArgumentError(
                    f"points row {row} lies beyond what the lens distortion describes; drop it."
                )
            radius = radius - (radius + self.kappa * radius**3 - straight) / slope
        ideal *= (radius / np.where(straight > 0, straight, 1.0))[:, None]
        pitch = np.array([self.pitch[0] / self.aspect, self.pitch[1]])
        return ideal / pitch + np.array(self.centre)

    def height_at(self, pixels, *, metres=1.75):
        """How tall a person stands in the image, by the pixel of the feet.

        Parameters
        ----------
        pixels : array_like, shape (n, 2)
            x, y of feet.
        metres : float, optional
            The person's height.

        Returns
        -------
        ndarray, shape (n,)
            Pixels.
        """
        pixels = require_points("pixels", pixels)
        metres = require_number("metres", metres, above=0, unit="metres")
        feet = self.to_ground(pixels)
        head = self.to_image(np.c_[feet, np.full(len(feet), metres)])
        return np.hypot(*(head - pixels).T)

    def scaled(self, factor):
        """The same camera for an image resized by `factor` (0.5: half as wide)."""
        factor = require_number("factor", factor, above=0)
        return replace(
            self,
            centre=tuple(factor * value for value in self.centre),
            pitch=tuple(value / factor for value in self.pitch),
        )


def place_of(turn, shift):
    """Where a camera stands, world metres, shape (3,).

    Parameters
    ----------
    turn : ndarray, shape (3, 3)
        World to camera.
    shift : ndarray, shape (3,)
        Millimetres.
    """
    return -turn.T @ shift / 1000.0


def _check_world(points):
    """Return points as floats of shape (n, 3), on the ground if they have no third."""
    try:
        points = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(f"points are not numbers ({fault}); pass rows of x, y, z.") from fault
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ArgumentError(f"points has the shape {points.shape}; pass rows of x, y or x, y, z.")
    if not np.isfinite(points).all():
        raise ArgumentError("points holds values that are not finite; drop those rows.")
    if points.shape[1] == 2:
        points = np.c_[points, np.zeros(len(points))]
    return points


@dataclass(frozen=True)
class Camera:
    """What is known of the camera that filmed the pairs: frames a second, and pixels."""

    frame_rate: float
    width: int
    height: int
