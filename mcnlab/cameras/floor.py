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

from collections.abc import Sized
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import HAIR, MOST_FAR, require_array, require_count, require_kind, require_number
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

    Raises
    ------
    ArgumentError
        When a number is out of range, or there are more than 25 million cells.

    Examples
    --------
    >>> grid = GridMap.over((0, 0, 6, 4), cell=0.5)
    >>> grid.shape
    (8, 12)
    >>> grid.inside([1.0, 7.0], [1.0, 1.0]).tolist()
    [True, False]
    """

    left: float
    bottom: float
    rows: int
    columns: int
    cell: float

    def __post_init__(self) -> None:
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
    def over(cls, area: ArrayLike, *, cell: float = 0.5) -> "GridMap":
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
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.rows, self.columns

    @property
    def area(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top, metres."""
        right = self.left + self.columns * self.cell
        return self.left, self.bottom, right, self.bottom + self.rows * self.cell

    @property
    def pixel(self) -> float:
        """Metres along a map pixel's side."""
        return self.cell / MAP_PIXELS

    def inside(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """Whether each point lies on the map."""
        left, bottom, right, top = self.area
        x, y = np.asarray(x, float), np.asarray(y, float)
        return (x >= left) & (x < right) & (y >= bottom) & (y < top)

    def cell_of(self, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
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

    def place_of(self, row: ArrayLike, column: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """The x and y of cells' centres, metres."""
        x = self.left + (np.asarray(column) + 0.5) * self.cell
        y = self.bottom + (np.asarray(row) + 0.5) * self.cell
        return x, y

    def centres(self) -> tuple[np.ndarray, np.ndarray]:
        """The cells' centres: x of each column, y of each row, metres."""
        x, _ = self.place_of(0, np.arange(self.columns))
        _, y = self.place_of(np.arange(self.rows), 0)
        return x, y


def check_area(area: ArrayLike, *, argument: str = "area") -> tuple[float, float, float, float]:
    """Return left, bottom, right, top as floats, or raise `ArgumentError`."""
    remedy = "finite left < right and bottom < top in metres"
    left, bottom, right, top = require_array(argument, area, (4,), remedy=remedy).tolist()
    if right <= left or top <= bottom:
        raise ArgumentError(f"{argument} is {area!r}; pass {remedy}.")
    return left, bottom, right, top


def check_walls(walls: ArrayLike | None, *, argument: str = "walls") -> np.ndarray:
    """Return walls as floats of shape (k, 2, 2), or raise `ArgumentError`.

    Parameters
    ----------
    walls : array_like, shape (k, 2, 2), or None
        The ends of segments, metres; None or nothing in it for none.
    argument : str, optional
        The argument's name, for the message.
    """
    if walls is None or (isinstance(walls, Sized) and len(walls) == 0):
        return np.empty((0, 2, 2))
    remedy = "the two ends of each, finite metres, shape (k, 2, 2)"
    return require_array(argument, walls, (None, 2, 2), low=-MOST_FAR, high=MOST_FAR, remedy=remedy)


def check_grid(grid: GridMap, *, argument: str = "grid") -> GridMap:
    """Return `grid` when it is a `GridMap`, or raise `ArgumentError`."""
    return require_kind(argument, grid, GridMap, "a GridMap, as from GridMap.over")
