"""Scenes and trace tables: halves that make a whole, and what is refused."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.datasets.scene import Scene, area_of
from mcnlab.errors import ArgumentError, TableError
from mcnlab.tables import FRAME, TRACE, X, Y, check_traces

AREA = (0.0, 0.0, 10.0, 5.0)


def walks(n=3, length=4):
    """n walkers side by side, `length` frames each."""
    return pd.DataFrame(
        {
            TRACE: np.repeat([f"w{number}" for number in range(n)], length),
            FRAME: np.tile(np.arange(length), n),
            X: np.tile(np.arange(length) * 0.5 + 1, n),
            Y: np.repeat(np.arange(n) * 1.0 + 1, length),
        }
    )


@given(st.integers(2, 30), st.integers(0, 2**32 - 1))
def test_halves_are_disjoint_and_complete(n, seed):
    scene = Scene("hall", walks(n), 10, AREA)
    first, second = scene.split(seed=seed)
    assert not set(first.walkers) & set(second.walkers)
    assert sorted(first.walkers + second.walkers) == sorted(scene.walkers)
    assert len(first.walkers) == n // 2
    whole = pd.concat([first.traces, second.traces]).sort_values([TRACE, FRAME])
    expected = scene.traces.sort_values([TRACE, FRAME])
    pd.testing.assert_frame_equal(whole.reset_index(drop=True), expected.reset_index(drop=True))


def test_a_split_keeps_the_place_and_depends_on_the_seed_alone():
    scene = Scene("hall", walks(20), 10, AREA, walls=[[[0, 0], [1, 1]]], problems=("x",))
    first, _ = scene.split(seed=4)
    assert (first.name, first.frame_rate, first.area, first.problems) == ("hall", 10, AREA, ("x",))
    assert first.walls.tolist() == [[[0, 0], [1, 1]]]
    assert first.walkers == scene.split(seed=4)[0].walkers
    assert first.walkers != scene.split(seed=5)[0].walkers


def test_one_walker_cannot_be_split():
    with pytest.raises(ArgumentError, match="needs two"):
        Scene("hall", walks(1), 10, AREA).split()


def test_seconds_count_walkers_not_time():
    assert Scene("hall", walks(3, 4), 2, AREA).seconds == 6


def test_a_scene_without_walls_has_none():
    for walls in (None, [], np.empty((0, 2, 2))):
        assert Scene("hall", walks(), 10, AREA, walls=walls).walls.shape == (0, 2, 2)


def test_the_area_holds_every_place_with_its_margin():
    table = walks(3, 4)  # x from 1 to 2.5, y from 1 to 3
    assert area_of(table, margin=0.5) == (0.5, 0.5, 3.0, 3.5)
    assert area_of(table.assign(x=table[X] + 0.01), margin=0.5) == (0.5, 0.5, 3.1, 3.5)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"frame_rate": 0}, "frame_rate"),
        ({"frame_rate": np.nan}, "frame_rate"),
        ({"area": (0, 0, 0, 5)}, "area"),
        ({"area": (0, 0, 10)}, "area"),
        ({"area": (0, 0, np.inf, 5)}, "area"),
        ({"area": None}, "area"),
        ({"walls": [[0, 0, 1, 1]]}, "walls"),
        ({"walls": [[[0, 0], [1, np.nan]]]}, "walls"),
    ],
)
def test_an_impossible_place_is_refused(change, word):
    with pytest.raises(ArgumentError, match=word):
        Scene(**{"name": "hall", "traces": walks(), "frame_rate": 10, "area": AREA, **change})


def test_a_sound_trace_table_comes_back():
    table = walks()
    assert check_traces(table) is table


def test_gaps_between_frames_are_allowed():
    check_traces(walks().drop(index=1))


def spoilt(column, row, value):
    table = walks().astype({column: object})
    table.loc[row, column] = value
    return table if isinstance(value, str) or column == TRACE else table.astype({column: float})


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (None, "NoneType"),
        ({"trace": []}, "dict"),
        (walks().drop(columns=X), "lacks.*x"),
        (pd.concat([walks(), walks()[[X]]], axis=1), "x twice"),
        (walks().iloc[:0], "no rows"),
        (spoilt(X, 2, "7"), "text or objects in x"),
        (spoilt(Y, 2, np.nan), "row 2 .*not finite"),
        (spoilt(Y, 2, -np.inf), "row 2 .*not finite"),
        (spoilt(X, 3, 1e300), "row 3 .*beyond any place"),
        (spoilt(FRAME, 1, 1e12), "row 1 .*beyond any place"),
        (spoilt(FRAME, 1, 0.5), "fractional"),
        (spoilt(FRAME, 1, 0), "repeated or unsorted frames in trace 'w0'"),
        (spoilt(TRACE, 1, None), "without a trace"),
        (walks().iloc[::-1], "repeated or unsorted"),
        (walks().sort_values(FRAME, kind="stable"), "repeated or unsorted"),
        (pd.concat([walks(), walks()]), "repeated or unsorted"),
    ],
)
def test_unsound_traces_are_refused(table, words):
    with pytest.raises(TableError, match=f"(?s){words}"):
        check_traces(table)


def test_the_message_names_the_argument():
    with pytest.raises(TableError, match=r"^truth "):
        check_traces(walks().iloc[:0], argument="truth")
