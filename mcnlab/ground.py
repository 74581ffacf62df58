"""Between the image and the ground: homographies, calibrated cameras and the grid map.

The thesis maps traces from the overhead view to a grid map by a homography (section 2.3,
Figure 2.9) and cuts the map into cells of 8×8 pixels.  Ground coordinates are metres,
x to the right and y upwards on the map, as seen from above.

References
----------
R. Hartley and A. Zisserman, "Multiple View Geometry in Computer Vision", 2004, chapter 4.
R. Tsai, "A versatile camera calibration technique", IEEE J. Robotics and Automation 3(4),
1987.
"""

from dataclasses import dataclass, replace

import numpy as np

from mcnlab.errors import ArgumentError, require_count, require_number

MAP_PIXELS = 8  # map pixels along a cell's side (thesis sections 2.2.1 and 2.3)
HAIR = 1e-9  # relative; nearer than this to an edge is on it
MOST_FAR = 1e12  # metres or pixels
MOST_CELLS = 25_000_000  # a grid beyond this is a mistake in units
# A triangle of points this flat, relative to the cloud's extent, leaves the plane free to tilt.
FLATNESS = 1e-3


@dataclass(frozen=True)
class GridMap:
    """The ground, cut into square cells.

    Attributes
    ----------
    left, bottom : float
        Metres; the corner of cell (0, 0).
    rows, columns : int
        Row 0 is the lowest, column 0 the leftmost.
    cell : float
        Metres along a cell's side.
    """

    left: float
    bottom: float
    rows: int
    columns: int
    cell: float

    def __post_init__(self):
        require_number("left", self.left, unit="metres")
        require_number("bottom", self.bottom, unit="metres")
        require_count("rows", self.rows, low=1)
        require_count("columns", self.columns, low=1)
        require_number("cell", self.cell, above=0, unit="metres")
        if self.rows * self.columns > MOST_CELLS:
            raise ArgumentError(
                f"cell is {self.cell:g} m, which makes {self.rows}×{self.columns} cells; "
                "pass a larger cell, or check that the area is in metres."
            )

    @classmethod
    def over(cls, area, *, cell=0.5):
        """The grid that covers an area.

        Parameters
        ----------
        area : tuple of float
            Left, bottom, right, top, metres.
        cell : float, optional
            Metres.
        """
        left, bottom, right, top = check_area(area)
        cell = require_number("cell", cell, above=0, unit="metres")
        # A hair's breadth beyond a whole number of cells is rounding, not another cell.
        rows, columns = (
            max(1, int(np.ceil(min(side / cell - HAIR, MOST_CELLS))))
            for side in (top - bottom, right - left)
        )
        return cls(left, bottom, rows, columns, cell)

    @property
    def shape(self):
        """Rows and columns."""
        return self.rows, self.columns

    @property
    def area(self):
        """Left, bottom, right, top, metres."""
        right = self.left + self.columns * self.cell
        return self.left, self.bottom, right, self.bottom + self.rows * self.cell

    @property
    def pixel(self):
        """Metres along a map pixel's side."""
        return self.cell / MAP_PIXELS

    def inside(self, x, y):
        """Whether each point lies on the map."""
        left, bottom, right, top = self.area
        x, y = np.asarray(x, float), np.asarray(y, float)
        return (x >= left) & (x < right) & (y >= bottom) & (y < top)

    def cell_of(self, x, y):
        """The row and column of each point.

        Raises
        ------
        ArgumentError
            When a point is not on the map; ask `inside` first.
        """
        if not self.inside(x, y).all():
            raise ArgumentError(
                f"x, y: {np.count_nonzero(~self.inside(x, y))} points lie outside the map; "
                "drop them, or make the map larger."
            )
        row = np.floor((np.asarray(y, float) - self.bottom) / self.cell).astype(int)
        column = np.floor((np.asarray(x, float) - self.left) / self.cell).astype(int)
        return np.minimum(row, self.rows - 1), np.minimum(column, self.columns - 1)

    def place_of(self, row, column):
        """The x and y of cells' centres, metres."""
        x = self.left + (np.asarray(column) + 0.5) * self.cell
        y = self.bottom + (np.asarray(row) + 0.5) * self.cell
        return x, y

    def centres(self):
        """The cells' centres: x of each column, y of each row, metres."""
        x, _ = self.place_of(0, np.arange(self.columns))
        _, y = self.place_of(np.arange(self.rows), 0)
        return x, y


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
        pixels = check_points("pixels", pixels)
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
        pixels = check_points("pixels", pixels)
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


def check_area(area, *, argument="area"):
    """Return left, bottom, right, top as floats, or raise `ArgumentError`."""
    try:
        left, bottom, right, top = (float(value) for value in area)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(
            f"{argument} is {area!r}; pass left, bottom, right, top in metres."
        ) from fault
    if not np.isfinite([left, bottom, right, top]).all() or right <= left or top <= bottom:
        raise ArgumentError(
            f"{argument} is {area!r}; pass finite left < right and bottom < top in metres."
        )
    return left, bottom, right, top


def check_points(name, points, *, low=1):
    """Return `points` as floats of shape (n, 2), or raise `ArgumentError`."""
    try:
        points = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(f"{name} are not numbers ({fault}); pass rows of x, y.") from fault
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < low:
        raise ArgumentError(
            f"{name} has the shape {points.shape}; pass at least {low} rows of x, y."
        )
    sound = (np.abs(points) <= MOST_FAR).all(axis=1)  # not so for NaN
    if not sound.all():
        row = int(np.flatnonzero(~sound)[0])
        raise ArgumentError(f"{name} row {row} is not finite, or beyond any place; mend it.")
    return points


def check_walls(walls, *, argument="walls"):
    """Return walls as floats of shape (k, 2, 2), or raise `ArgumentError`.

    Parameters
    ----------
    walls : array_like, shape (k, 2, 2), or None
        The ends of segments, metres; None or nothing in it for none.
    argument : str, optional
        The argument's name, for the message.
    """
    try:
        walls = np.asarray(() if walls is None else walls, dtype=float)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(
            f"{argument} are not numbers ({fault}); pass the two ends of each, shape (k, 2, 2)."
        ) from fault
    walls = walls.reshape(0, 2, 2) if walls.size == 0 else walls
    if walls.shape[1:] != (2, 2):
        raise ArgumentError(
            f"{argument} has the shape {walls.shape}; pass the two ends of each, shape (k, 2, 2)."
        )
    sound = (np.abs(walls) <= MOST_FAR).all(axis=(1, 2))  # not so for NaN
    if not sound.all():
        row = int(np.flatnonzero(~sound)[0])
        raise ArgumentError(f"{argument} row {row} is not finite, or beyond any place; mend it.")
    return walls


def check_grid(grid, *, argument="grid"):
    """Return `grid` when it is a `GridMap`, or raise `ArgumentError`."""
    if not isinstance(grid, GridMap):
        raise ArgumentError(
            f"{argument} is a {type(grid).__name__}; pass a GridMap, as from GridMap.over."
        )
    return grid


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


def find_homography(image_points, ground_points):
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
    """
    image = check_points("image_points", image_points, low=4)
    ground = check_points("ground_points", ground_points, low=4)
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


def project(homography, points):
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
    """
    matrix = check_homography(homography)
    points = check_points("points", points)
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


def check_homography(homography):
    """Return a homography as floats, or raise `ArgumentError`."""
    try:
        matrix = np.asarray(homography, dtype=float)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(f"homography is not a matrix of numbers: {fault}.") from fault
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise ArgumentError("homography must be a finite 3×3 matrix; see find_homography.")
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
