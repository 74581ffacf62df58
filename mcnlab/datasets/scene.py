"""One place and the traces of those who walked there."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mcnlab.columns import TRACE, X, Y, check_traces
from mcnlab.errors import ArgumentError, require_number
from mcnlab.ground import check_area

NO_WALLS = np.empty((0, 2, 2))


@dataclass(frozen=True, eq=False)
class Scene:
    """Walkers' traces on the ground of one place.

    Attributes
    ----------
    name : str
    traces : pandas.DataFrame
        A trace table, metres.
    frame_rate : float
        Frames a second.
    area : tuple of float
        Left, bottom, right, top, metres.
    walls : ndarray, shape (k, 2, 2)
        Segments that block sight: (x, y) of both ends, metres.
    blocks : ndarray, shape (k, 4)
        Rectangles that are no floor: left, bottom, right, top, metres.
    source : str
        Where it came from: "bundled", "measured", "synthetic", …
    problems : tuple of str
        What was left out, and why.
    """

    name: str
    traces: pd.DataFrame
    frame_rate: float
    area: tuple
    walls: np.ndarray = None
    blocks: np.ndarray = ()
    source: str = ""
    problems: tuple = ()

    def __post_init__(self):
        check_traces(self.traces)
        require_number("frame_rate", self.frame_rate, above=0, unit="frames a second")
        object.__setattr__(self, "area", check_area(self.area))
        walls = NO_WALLS if self.walls is None else np.asarray(self.walls, dtype=float)
        if walls.size == 0:
            walls = NO_WALLS
        if walls.shape[1:] != (2, 2) or not np.isfinite(walls).all():
            raise ArgumentError(
                f"walls has the shape {walls.shape}; pass finite segments, shape (k, 2, 2)."
            )
        object.__setattr__(self, "walls", walls)
        blocks = [check_area(block, argument="blocks") for block in self.blocks]
        object.__setattr__(self, "blocks", np.array(blocks).reshape(-1, 4))

    @property
    def walkers(self):
        """The traces' names, in table order."""
        return list(self.traces[TRACE].unique())

    @property
    def seconds(self):
        """Walker-seconds in all."""
        return len(self.traces) / self.frame_rate

    def with_traces(self, traces):
        """The same place with other traces."""
        return replace(self, traces=traces.reset_index(drop=True))

    def split(self, *, seed=0):
        """Two scenes, each with half of the walkers, drawn at random.

        Raises
        ------
        ArgumentError
            When there are fewer than two walkers.
        """
        walkers = np.array(self.walkers, dtype=object)
        if len(walkers) < 2:
            raise ArgumentError(f"scene {self.name!r} has one walker; a split needs two.")
        drawn = np.random.default_rng(seed).permutation(len(walkers))[: len(walkers) // 2]
        first = self.traces[TRACE].isin(walkers[drawn])
        return self.with_traces(self.traces[first]), self.with_traces(self.traces[~first])


def area_of(traces, *, margin=1.0):
    """The area that traces cover, with a margin, to whole decimetres (metres)."""
    check_traces(traces)
    low = np.floor(10 * (traces[[X, Y]].min().to_numpy() - margin)) / 10
    high = np.ceil(10 * (traces[[X, Y]].max().to_numpy() + margin)) / 10
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])
