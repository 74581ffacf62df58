"""The camera: where points of the world are seen, and what a pixel sees.

The world is metres, x to the right, y ahead and z up; the ground is z = 0.  A camera looks
along its z axis, with x to the right in the image and y down.  The centre of the top-left
pixel is (0, 0), so that of a frame is ((width − 1)/2, (height − 1)/2).

References
----------
R. Hartley and A. Zisserman, "Multiple View Geometry in Computer Vision", 2004, chapter 6.
R. Tsai, "A versatile camera calibration technique", IEEE J. Robotics and Automation 3(4),
1987.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import rq
from scipy.spatial.transform import Rotation

from mcnlab.checks import require_all, require_array, require_count, require_number, require_points
from mcnlab.errors import ArgumentError

ROUNDING = 1e-5  # by which a published rotation may miss being one


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera, with a lens that may distort.

    Attributes
    ----------
    intrinsics : ndarray, shape (3, 3)
        Focal lengths, skew and principal point, pixels; upper triangular, the last is 1.
    rotation : ndarray, shape (3, 3)
        World to camera.
    translation : ndarray, shape (3,)
        Metres: a point X of the world lies at ``rotation @ X + translation``.
    frame_width, frame_height : int
        Pixels.
    distortion : float
        Tsai's κ in normalised coordinates: what is seen at the radius r would be seen at
        ``r·(1 + distortion·r²)`` without distortion.

    Raises
    ------
    ArgumentError
        When an array has another shape, or is no such matrix.

    Examples
    --------
    >>> camera = Camera.from_tilt(
    ...     focal_length=800, height=3, tilt=30, frame_width=641, frame_height=481
    ... )
    >>> camera.to_ground([[320, 240]]).round(2)
    array([[0. , 5.2]])
    >>> camera.project([[0, 5.2, 0], [1, 8, 1.7]]).round(1)
    array([[320. , 239.7],
           [425.6, -63.4]])
    >>> camera.see([[0, 5.2, 0], [0, -9, 0]])[1]
    array([ True, False])
    """

    intrinsics: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    frame_width: int
    frame_height: int
    distortion: float = 0.0

    def __post_init__(self) -> None:
        for name, shape in (("intrinsics", (3, 3)), ("rotation", (3, 3)), ("translation", (3,))):
            array = require_array(name, getattr(self, name), shape).copy()
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        lens, turn = self.intrinsics, self.rotation
        if min(lens[0, 0], lens[1, 1]) <= 0 or lens[[1, 2, 2], [0, 0, 1]].any() or lens[2, 2] != 1:
            raise ArgumentError(
                f"intrinsics is {lens.tolist()}; pass [[fx, skew, x], [0, fy, y], [0, 0, 1]] with "
                "positive focal lengths fx and fy, pixels."
            )
        if np.abs(turn @ turn.T - np.eye(3)).max() > ROUNDING or np.linalg.det(turn) < 0:
            raise ArgumentError(
                f"rotation is {turn.tolist()}; pass a matrix that turns and does not mirror."
            )
        require_count("frame_width", self.frame_width, low=1)
        require_count("frame_height", self.frame_height, low=1)
        require_number("distortion", self.distortion)

    @classmethod
    def from_tilt(
        cls,
        *,
        focal_length: float,
        height: float,
        tilt: float,
        roll: float = 0.0,
        frame_width: int,
        frame_height: int,
        place: ArrayLike = (0.0, 0.0),
    ) -> "Camera":
        """A camera above the ground that looks along y, its axis in the middle of the frame.

        Parameters
        ----------
        focal_length : float
            Pixels.
        height : float
            Metres above the ground.
        tilt : float
            Degrees below the horizontal, −90 to 90.
        roll : float, optional
            Degrees by which the image turns clockwise.
        frame_width, frame_height : int
            Pixels.
        place : array_like, shape (2,), optional
            x and y of the point below the camera, metres.
        """
        focal_length = require_number("focal_length", focal_length, above=0, unit="pixels")
        height = require_number("height", height, above=0, unit="metres")
        tilt = require_number("tilt", tilt, low=-90, high=90, unit="degrees")
        roll = require_number("roll", roll, unit="degrees")
        x = (require_count("frame_width", frame_width, low=1) - 1) / 2
        y = (require_count("frame_height", frame_height, low=1) - 1) / 2
        lens = np.array([[focal_length, 0, x], [0, focal_length, y], [0, 0, 1]])
        turn = Rotation.from_euler("xz", [90 + tilt, roll], degrees=True).as_matrix()
        centre = np.append(require_array("place", place, (2,)), height)
        return cls(lens, turn, -turn @ centre, frame_width, frame_height)

    @classmethod
    def from_matrix(cls, matrix: ArrayLike, frame_size: tuple[int, int]) -> "Camera":
        """The camera of a projection matrix, which may have any scale and sign.

        Parameters
        ----------
        matrix : array_like, shape (3, 4)
            World, in metres, to image, in homogeneous coordinates.
        frame_size : (int, int)
            Width and height, pixels.

        Raises
        ------
        ArgumentError
            When the matrix is of no camera at a finite place.
        """
        held = require_array("matrix", matrix, (3, 4))
        held = held / (np.linalg.norm(held[:, :3]) or 1.0)
        determinant = np.linalg.det(held[:, :3])
        if abs(determinant) < 1e-12:
            raise ArgumentError("matrix sees from infinitely far; pass that of a real camera.")
        held = held * np.sign(determinant)
        lens, turn = rq(held[:, :3])
        signs = np.sign(np.diag(lens))
        lens, turn = lens * signs, signs[:, None] * turn
        shift = np.linalg.solve(lens, held[:, 3])
        return cls(np.triu(lens / lens[2, 2]), turn, shift, *frame_size)

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, Camera) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple:
        arrays = (self.intrinsics, self.rotation, self.translation)
        size = self.frame_width, self.frame_height, self.distortion
        return *(tuple(array.ravel().tolist()) for array in arrays), *size

    @property
    def focal_length(self) -> float:
        """Across the image, pixels."""
        return float(self.intrinsics[0, 0])

    @property
    def centre(self) -> np.ndarray:
        """Where the camera stands, world metres, shape (3,)."""
        return -self.rotation.T @ self.translation

    @property
    def horizon(self) -> float | None:
        """Row of the horizon in the frame's middle column, pixels, as without distortion.

        None where it never crosses that column, as when the camera looks straight down.
        """
        line = np.linalg.solve(self.intrinsics.T, self.rotation[:, 2])
        if abs(line[1]) * self.intrinsics[1, 1] < 1e-12:
            return None
        return float(-(line[0] * (self.frame_width - 1) / 2 + line[2]) / line[1])

    @property
    def homography(self) -> np.ndarray:
        """Image to ground, shape (3, 3).

        Raises
        ------
        ArgumentError
            When the lens distorts, or the camera lies in the ground.
        """
        if self.distortion != 0:
            raise ArgumentError("a lens that distorts has no homography; use to_ground.")
        if self.centre[2] == 0:
            raise ArgumentError("a camera in the ground has no homography; raise it.")
        looks = np.c_[self.rotation[:, :2], self.translation]
        inverse = np.linalg.inv(self.intrinsics @ looks)
        last = inverse[2, 2]
        return inverse / (last if abs(last) > 1e-12 else np.linalg.norm(inverse))

    def depth(self, points: ArrayLike) -> np.ndarray:
        """How far points lie ahead along the optical axis, metres; not positive behind.

        Parameters
        ----------
        points : array_like, shape (..., 3) or (..., 2)
            World metres; on the ground if two.

        Returns
        -------
        ndarray, shape (...)
        """
        return _check_world(points) @ self.rotation[2] + self.translation[2]

    def project(self, points: ArrayLike) -> np.ndarray:
        """Where points are seen, within the frame or beyond its edges.

        Parameters
        ----------
        points : array_like, shape (..., 3) or (..., 2)
            World metres; on the ground if two.

        Returns
        -------
        ndarray, shape (..., 2)
            x, y, pixels.

        Raises
        ------
        ArgumentError
            When a point is not finite or not in front of the camera, or lies so far out
            that the distortion folds over; `see` takes such points.
        """
        pixels, depth = self._image(_check_world(points))
        remedy = "such a point lies behind the camera: drop it, or use see"
        require_all("points' depth", depth, depth > 0, remedy)
        remedy = "that is beyond what the lens distortion describes: drop it, or use see"
        require_all("points' depth", depth, np.isfinite(pixels).all(axis=-1), remedy)
        return pixels

    def see(self, points: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """What the camera sees of any points, behind it and beside it too.

        Parameters
        ----------
        points : array_like, shape (..., 3) or (..., 2)
            World metres; on the ground if two.

        Returns
        -------
        pixels : ndarray, shape (..., 2)
            As of `project`, NaN where there is no image.
        visible : ndarray of bool, shape (...)
            Whether the point is in front of the camera and within the frame.
        """
        pixels, _ = self._image(_check_world(points))
        edge = np.array([self.frame_width, self.frame_height]) - 0.5
        within = (pixels >= -0.5) & (pixels < edge)
        return pixels, np.asarray(within.all(axis=-1))

    def ray(self, pixels: ArrayLike) -> np.ndarray:
        """The directions in the world that pixels look in.

        Parameters
        ----------
        pixels : array_like, shape (n, 2)
            x, y.

        Returns
        -------
        ndarray, shape (n, 3)
            Unit vectors.

        Raises
        ------
        ArgumentError
            When a pixel is beyond what the lens distortion describes.
        """
        pixels = require_points("pixels", pixels)
        seen = np.c_[pixels, np.ones(len(pixels))] @ np.linalg.inv(self.intrinsics).T
        square = (seen[:, :2] ** 2).sum(axis=1)
        sound = np.stack([1 + 3 * self.distortion * square > 0] * 2, axis=1)
        require_all("pixels", pixels, sound, "the lens distortion does not reach that far; drop it")
        seen[:, :2] *= 1 + self.distortion * square[:, None]
        return seen @ self.rotation / np.linalg.norm(seen, axis=1, keepdims=True)

    def to_ground(self, pixels: ArrayLike) -> np.ndarray:
        """Where the rays through pixels meet the ground.

        Parameters
        ----------
        pixels : array_like, shape (n, 2)
            x, y.

        Returns
        -------
        ndarray, shape (n, 2)
            World metres.

        Raises
        ------
        ArgumentError
            When a pixel lies on or above the horizon.
        """
        rays, centre = self.ray(pixels), self.centre
        falling = rays[:, 2] * centre[2] < 0
        if not falling.all():
            raise ArgumentError(
                f"pixels: {np.count_nonzero(~falling)} lie on or above the horizon and see no "
                f"ground, row {np.argmin(falling)} for one; drop them."
            )
        return centre[:2] - centre[2] / rays[:, 2:] * rays[:, :2]

    def height_at(self, pixels: ArrayLike, *, metres: float = 1.75) -> np.ndarray:
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
        feet = self.to_ground(pixels)
        metres = require_number("metres", metres, above=0, unit="metres")
        head = self.project(np.c_[feet, np.full(len(feet), metres)])
        return np.hypot(*(head - np.asarray(pixels, float)).T)

    def scaled(self, factor: float) -> "Camera":
        """The same camera for an image resized by `factor` (0.5: half as wide).

        The edges of the image stay its edges, so that the pixel p becomes
        ``factor·(p + ½) − ½``.
        """
        factor = require_number("factor", factor, above=0)
        resize = np.array([[factor, 0, (factor - 1) / 2], [0, factor, (factor - 1) / 2], [0, 0, 1]])
        width, height = (
            max(1, round(factor * side)) for side in (self.frame_width, self.frame_height)
        )
        lens = resize @ self.intrinsics
        return replace(self, intrinsics=lens, frame_width=width, frame_height=height)

    def _image(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pixels, NaN where there are none, and depth."""
        inside = points @ self.rotation.T + self.translation
        depth = inside[..., 2]
        seen = inside / np.where(depth > 0, depth, np.nan)[..., None]
        if self.distortion != 0:
            straight = np.hypot(seen[..., 0], seen[..., 1])
            bent = _bend(straight, self.distortion)
            seen[..., :2] *= (bent / np.where(straight > 0, straight, 1.0))[..., None]
        return seen @ self.intrinsics[:2].T, depth


def _bend(straight: np.ndarray, distortion: float) -> np.ndarray:
    """The radius r with r + distortion·r³ = straight; NaN beyond where that folds over."""
    # With s = sinh x, 3s + 4s³ = sinh 3x; with s = sin x, 3s − 4s³ = sin 3x.
    scale = np.sqrt(3 * abs(distortion))
    triple = 1.5 * scale * straight
    if distortion > 0:
        return 2 / scale * np.sinh(np.arcsinh(triple) / 3)
    return 2 / scale * np.sin(np.arcsin(np.where(triple < 1, triple, np.nan)) / 3)


def _check_world(points: ArrayLike) -> np.ndarray:
    """Return points as floats of shape (..., 3), on the ground if they have no third."""
    remedy = "finite x, y, z along the last axis, metres, or x, y on the ground"
    points = require_array("points", points, (..., None), remedy=remedy)
    if points.shape[-1] not in (2, 3):
        raise ArgumentError(f"points has the shape {points.shape}; pass {remedy}.")
    if points.shape[-1] == 2:
        points = np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
    return points
