"""Homographies: between two planes, exact and checked."""

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import require_array, require_points
from mcnlab.errors import ArgumentError

# A triangle of points this flat, relative to the cloud's extent, leaves the plane free to tilt.
FLATNESS = 1e-3


def find_homography(image_points: ArrayLike, ground_points: ArrayLike) -> np.ndarray:
    """The homography that takes image points to the ground (Figure 2.9).

    Parameters
    ----------
    image_points : array_like, shape (n, 2)
        Pixels; at least four, no three of the four on a line.
    ground_points : array_like, shape (n, 2)
        Metres, in the same order.

    Returns
    -------
    ndarray, shape (3, 3)
        Its last element is one unless the image's origin sees no ground.

    Raises
    ------
    ArgumentError
        When there are fewer than four points, as many on both sides are not given, one
        is not finite, points repeat, or they lie on a line.  OpenCV's findHomography
        returns a matrix of rank one for such points, in silence, and rounds to single
        precision; hence our own, the normalised direct linear transform.

    Examples
    --------
    >>> pixels = [[0, 0], [100, 0], [80, 50], [20, 50]]
    >>> metres = [[0, 0], [10, 0], [10, 8], [0, 8]]
    >>> project(find_homography(pixels, metres), [[50, 25]]).round(2)
    array([[5., 3.]])
    """
    image = require_points("image_points", image_points, least=4)
    ground = require_points("ground_points", ground_points, least=4)
    if len(image) != len(ground):
        raise ArgumentError(
            f"image_points has {len(image)} rows, ground_points {len(ground)}; pass them in pairs."
        )
    for name, points in (("image_points", image), ("ground_points", ground)):
        _check_spread(name, points)
    (image, from_image), (ground, from_ground) = _normalise(image), _normalise(ground)
    # The direct linear transform: each pair is two equations, h the direction that all
    # leave free, or nearly so.
    rays, none = np.c_[image, np.ones(len(image))], np.zeros((len(image), 3))
    equations = np.concatenate(
        [
            np.c_[rays, none, -ground[:, :1] * rays],
            np.c_[none, rays, -ground[:, 1:] * rays],
        ]
    )
    triangle = np.linalg.qr(equations, mode="r")  # nine rows at most, however many points
    within = np.linalg.svd(triangle)[2][-1].reshape(3, 3)
    # Nearly zero in normalised coordinates means that a plane became a line.
    if abs(np.linalg.det(within)) < 1e-9:
        raise ArgumentError(
            "image_points and ground_points admit only a degenerate homography; "
            "check that the pairs are in the same order."
        )
    side = rays @ within[2]
    if side.min() < 0 < side.max():
        raise ArgumentError(
            "image_points lie on both sides of the horizon that they give; check that the pairs "
            "are in the same order."
        )
    homography = np.linalg.inv(from_ground) @ within @ from_image
    last = homography[2, 2]
    return homography / (last if abs(last) > 1e-12 else np.linalg.norm(homography))


def project(homography: ArrayLike, points: ArrayLike) -> np.ndarray:
    """Take points through a homography.

    Beyond the horizon a homography shows ground that lies behind the camera.  Which side is
    which it does not tell, as it is known up to its sign; but all points must lie on one.

    Parameters
    ----------
    homography : array_like, shape (3, 3)
    points : array_like, shape (n, 2)

    Returns
    -------
    ndarray, shape (n, 2)

    Raises
    ------
    ArgumentError
        When the matrix is not a finite, invertible 3×3, a point falls on the horizon, or
        some points lie on the other side of it.

    Examples
    --------
    >>> project([[2, 0, 1], [0, 2, 0], [0, 0, 1]], [[3, 4]])
    array([[7., 8.]])
    """
    matrix = check_homography(homography)
    points = require_points("points", points)
    rays = np.c_[points, np.ones(len(points))] @ matrix.T
    scale = np.abs(rays).max(axis=1)
    if (np.abs(rays[:, 2]) < 1e-12 * scale).any():
        row = int(np.flatnonzero(np.abs(rays[:, 2]) < 1e-12 * scale)[0])
        raise ArgumentError(f"points row {row} lies on the horizon, which has no ground; drop it.")
    strays = rays[:, 2] * rays[0, 2] < 0
    if strays.any():
        # Those on the side of fewer points; where they are as many, not on that of the first.
        strays = strays if 2 * np.count_nonzero(strays) <= len(strays) else ~strays
        raise ArgumentError(
            f"points row {np.argmax(strays)} lies beyond the horizon, on the other side of it than "
            f"{np.count_nonzero(~strays)} of the points, and has no ground; drop such rows."
        )
    return rays[:, :2] / rays[:, 2:]


def check_homography(homography: ArrayLike) -> np.ndarray:
    """Return a homography as floats, or raise `ArgumentError`."""
    remedy = "a finite 3×3 matrix, as from find_homography"
    matrix = require_array("homography", homography, (3, 3), remedy=remedy)
    if np.linalg.matrix_rank(matrix) < 3:
        raise ArgumentError(
            "homography has no inverse: it takes the plane to a line or a point; find it anew "
            "from four points, no three on a line."
        )
    return matrix


def _normalise(points):
    """Points about their mean at mean distance √2 (Hartley), and the matrix that does it."""
    middle = points.mean(axis=0)
    scale = np.sqrt(2.0) / np.linalg.norm(points - middle, axis=1).mean()
    matrix = np.array([[scale, 0, -scale * middle[0]], [0, scale, -scale * middle[1]], [0, 0, 1]])
    return (points - middle) * scale, matrix


def _check_spread(name, points):
    """Four different points must span a quadrilateral: no three of them on a line."""
    distinct = np.unique(points, axis=0)
    if len(distinct) < 4:
        raise ArgumentError(
            f"{name} holds {len(distinct)} different points; pass at least four, none repeated."
        )
    # A homography is fixed when the points less any one still do not lie on a line.
    for left_out in range(len(distinct) if len(distinct) <= 8 else 0):
        rest = np.delete(distinct, left_out, axis=0)
        if _flatness(rest) < FLATNESS:
            raise ArgumentError(
                f"{name} lie on a line, but for at most one of them; pass four of which no three "
                "are on a line."
            )
    if _flatness(distinct) < FLATNESS:
        raise ArgumentError(f"{name} lie on a line; pass points that span the ground.")


def _flatness(points):
    """Smaller over larger extent of a cloud of points."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return spread[1] / spread[0] if spread[0] > 0 else 0.0
