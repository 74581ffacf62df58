"""One place and the traces of those who walked there."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mcnlab.cameras.floor import check_area, check_walls
from mcnlab.checks import require_count, require_number
from mcnlab.errors import ArgumentError
from mcnlab.tables import TRACE, X, Y, check_traces


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
    people : dict
        Trace → who left it, where one person left several; a trace that is not named is
        a person of its own.
    source : str
        Where it came from: "bundled", "measured", "synthetic", …
    problems : tuple of str
        What was left out, and why.

    Examples
    --------
    >>> traces = pd.DataFrame({"trace": "1", "frame": range(8), "x": 0.2, "y": range(8)})
    >>> scene = Scene("yard", traces, frame_rate=4.0, area=area_of(traces))
    >>> scene.area, scene.seconds
    ((-0.8, -1.0, 1.2, 8.0), 2.0)
    """

    name: str
    traces: pd.DataFrame
    frame_rate: float
    area: tuple
    walls: np.ndarray = None
    blocks: np.ndarray | tuple = ()
    people: dict = None
    source: str = ""
    problems: tuple = ()

    def __post_init__(self):
        check_traces(self.traces)
        require_number("frame_rate", self.frame_rate, above=0, unit="frames a second")
        object.__setattr__(self, "area", check_area(self.area))
        object.__setattr__(self, "walls", check_walls(self.walls))
        blocks = () if self.blocks is None else self.blocks
        blocks = [check_area(block, argument="blocks") for block in blocks]
        object.__setattr__(self, "blocks", np.array(blocks).reshape(-1, 4))
        object.__setattr__(self, "people", dict(self.people or {}))

    @property
    def walkers(self) -> list[str]:
        """The traces' names, in table order."""
        return list(self.traces[TRACE].unique())

    @property
    def seconds(self) -> float:
        """Walker-seconds in all."""
        return len(self.traces) / self.frame_rate

    def with_traces(self, traces: pd.DataFrame) -> "Scene":
        """The same place with other traces."""
        return replace(self, traces=traces.reset_index(drop=True))

    def who(self, traces: Iterable[str]) -> np.ndarray:
        """The person behind each of some traces' names, ndarray of object."""
        return np.array([self.people.get(trace, trace) for trace in traces], dtype=object)

    def split(self, *, seed: int = 0) -> tuple["Scene", "Scene"]:
        """Two scenes, each with half of the people, drawn at random.

        Raises
        ------
        ArgumentError
            When there are fewer than two people.
        """
        seed = require_count("seed", seed)
        person = self.who(self.traces[TRACE])
        people = np.array(list(dict.fromkeys(person)), dtype=object)
        if len(people) < 2:
            raise ArgumentError(f"scene {self.name!r} has one walker; a split needs two.")
        drawn = np.random.default_rng(seed).permutation(len(people))[: len(people) // 2]
        first = np.isin(person, people[drawn])
        return self.with_traces(self.traces[first]), self.with_traces(self.traces[~first])


def area_of(traces: pd.DataFrame, *, margin: float = 1.0) -> tuple[float, float, float, float]:
    """The area that traces cover, with a margin, to whole decimetres (metres)."""
    check_traces(traces)
    margin = require_number("margin", margin, low=0, unit="metres")
    low = np.floor(10 * (traces[[X, Y]].min().to_numpy() - margin)) / 10
    high = np.ceil(10 * (traces[[X, Y]].max().to_numpy() + margin)) / 10
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])
