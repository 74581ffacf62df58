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

from dataclasses import dataclass

import numpy as np

from mcnlab.checks import HAIR, MOST_FAR, require_count, require_number
from mcnlab.errors import ArgumentError

MAP_PIXELS = 8  # map pixels along a cell's side (thesis sections 2.2.1 and 2.3)
MOST_CELLS = 25_000_000  # a grid beyond this is a mistake in units


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
