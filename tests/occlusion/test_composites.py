"""Composites are judged by their boxes, after one second of both walks."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.datasets.mirror import mirror_boxes, mirror_direction
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, McnError
from mcnlab.occlusion import thesis
from mcnlab.occlusion.composites import compose, compose_all


def naive(recording, row):
    """What happens in a composite, frame by frame: seconds and place of the first cover."""
    both = compose(recording, row.first, row.second, shift=row.shift)
    one, two = (both.sequence(name).set_index("frame") for name in (row.first, row.second))
    now, found = None, (np.inf, None, None)
    for frame in sorted(set(one.index) & set(two.index)):
        a, b = one.loc[frame], two.loc[frame]
        left, top = max(a.x, b.x), max(a.y, b.y)
        right, bottom = min(a.x + a.w, b.x + b.w), min(a.y + a.h, b.y + b.h)
        cover = max(right - left, 0) * max(bottom - top, 0) / min(a.w * a.h, b.w * b.h)
        if frame == row.frame:
            now = cover
        if frame > row.frame and cover > 0.3:
            return now, (frame - row.frame) / 25, (left + right - 1) / 2, (top + bottom - 1) / 2
    return now, *found


def test_the_truth_is_what_the_boxes_do_frame_by_frame(composites):
    for row in composites.table.sample(60, random_state=1).itertuples():
        now, seconds, x, y = naive(composites.recording, row)
        assert now <= 0.05
        assert row.occludes == np.isfinite(seconds)
        assert row.seconds == pytest.approx(seconds)
        if row.occludes:
            assert (row.x, row.y) == (x, y)


def test_the_decision_sees_one_second_of_both(composites):
    for row in composites.table.sample(30, random_state=2).itertuples():
        both = compose(composites.recording, row.first, row.second, shift=row.shift)
        walks = [both.sequence(name) for name in (row.first, row.second)]
        assert row.frame == max(int(walk["frame"].iloc[0]) for walk in walks) + 24
        now = [walk[walk["frame"] == row.frame].iloc[0] for walk in walks]
        then = [walk[walk["frame"] == row.frame - 24].iloc[0] for walk in walks]
        one, two = (1, 0) if row.swapped else (0, 1)
        assert (row.x1, row.y1) == (now[one]["cx"], now[one]["cy"])
        assert (row.x2, row.y2) == (now[two]["cx"], now[two]["cy"])
        assert row.x1 <= row.x2
        # 25 frames span 24/25 of a second.
        for p, at in ((row.p1, one), (row.p2, two)):
            moved = np.hypot(now[at]["cx"] - then[at]["cx"], now[at]["cy"] - then[at]["cy"])
            assert p == pytest.approx(moved * 25 / 24)
        last = min(int(walk["frame"].iloc[-1]) for walk in walks)
        assert row.left == pytest.approx((last - row.frame) / 25)


def test_what_is_said_is_what_the_tables_say(composites):
    table = composites.table
    looked_up = thesis.look_up(
        *(table[f"{what}{who}"] for what in ("direction", "level") for who in (1, 2))
    )
    np.testing.assert_array_equal(table["rule"], looked_up)
    assert (table["said"] == np.isfinite(table["said_seconds"])).all()
    assert table.loc[table["rule"] == thesis.CERTAIN, "said"].all()
    assert not table.loc[table["rule"] == thesis.APART, "said"].any()
    measured = table[["x", "y", "said_x", "said_y", "x1", "x2", "p1", "p2", "left"]]
    assert np.isfinite(measured.to_numpy()).all()


def test_directions_of_one_second_are_nearly_always_the_true_ones(composites, casia):
    table = composites.table
    for side in ("1", "2"):
        first = table["swapped"] == (side == "2")
        name = np.where(first, table["first"], table["second"])
        assert (casia.directions[name].to_numpy() == table[f"direction{side}"]).mean() > 0.97


def test_everybody_meets_everybody_else_once_a_shift(composites, casia):
    table = composites.table
    assert not table.duplicated(["first", "second", "shift"]).any()
    assert (composites.people("first") != composites.people("second")).all()
    together = table[table["shift"] == 0]
    pairs = {frozenset(pair) for pair in zip(together["first"], together["second"], strict=True)}
    assert len(pairs) == len(together)
    assert sorted(table["shift"].unique()) == [0, 12, 25, 38, 50]


def test_a_mirrored_scene_swaps_the_walkers_and_nothing_else(street):
    recording = street.recording
    twin = recording.with_boxes(
        mirror_boxes(recording.boxes, frame_width=recording.frame_width),
        directions=recording.directions.map(mirror_direction),
    )
    here = street.table
    there = compose_all(twin, focal_length=450, shifts=[0]).table
    for name in ("first", "second", "rule", "said", "occludes", "seconds", "left"):
        assert (here[name] == there[name]).all(), name
    assert (here["swapped"] != there["swapped"]).all()
    for one, two in (("1", "2"), ("2", "1")):
        turned = mirror_direction(there[f"direction{two}"].to_numpy())
        assert (here[f"direction{one}"] == turned).all()
        assert (here[f"level{one}"] == there[f"level{two}"]).all()
    # Mirroring is exact to 1/16 pixel and times are quotients: rounding only.
    np.testing.assert_allclose(here["said_seconds"], there["said_seconds"], rtol=1e-9)
    middle = recording.frame_width - 1
    np.testing.assert_allclose(here["said_x"], middle - there["said_x"], atol=1e-6)
    np.testing.assert_allclose(here["said_y"], there["said_y"], atol=1e-6)
    np.testing.assert_allclose(here["x"], middle - there["x"], atol=1e-9)


def test_a_meeting_head_on_is_foreseen_to_the_frame(make_walks):
    pair = make_walks(a=(100.0, 3.0), b=(400.0, -3.0))
    row = compose_all(pair, focal_length=450, shifts=[0]).table.iloc[0]
    # 300 px apart less 2 · 24 · 3 seen, at 2 · 75 px/s.
    assert row["said_seconds"] == pytest.approx(156 / 150)
    assert row["said_x"] == pytest.approx(250)
    # More than 12 of 40 px shared: less than 28 apart, 129 of 156 px later, by 6 a frame.
    assert row["seconds"] == pytest.approx(22 / 25)
    assert (row["direction1"], row["direction2"], row["rule"]) == (3, 7, thesis.CERTAIN)


def test_walks_of_one_second_have_nothing_left(make_boxes):
    tables = [
        make_boxes(
            25,
            sequence=name,
            subject=name,
            x=x + step * np.arange(25) - 20,
            cx=x + step * np.arange(25),
            h=100.0,
            cy=110.0,
        )
        for name, x, step in (("a", 100.0, 3.0), ("b", 400.0, -3.0))
    ]
    pair = Recording("made", pd.concat(tables, ignore_index=True), 25.0, 640, 480)
    row = compose_all(pair, focal_length=450, shifts=[0]).table.iloc[0]
    assert (row["left"], row["seconds"], row["occludes"]) == (0, np.inf, False)


def test_the_order_of_the_walks_says_nothing(make_walks):
    walks = {"a": (100.0, 3.0), "b": (400.0, -3.0)}
    one = compose_all(make_walks(**walks), focal_length=450, shifts=[0])
    turned = dict(reversed(walks.items()))
    other = compose_all(make_walks(**turned), focal_length=450, shifts=[0])
    assert bool(one.table["swapped"][0]) is not bool(other.table["swapped"][0])
    drop = ["first", "second", "swapped"]
    pd.testing.assert_frame_equal(one.table.drop(columns=drop), other.table.drop(columns=drop))


def test_walkers_one_above_the_other_are_not_told_apart(make_boxes):
    tables = [
        make_boxes(
            60,
            sequence=name,
            subject=name,
            x=100.0 + 3 * np.arange(60),
            cx=120.0 + 3 * np.arange(60),
            y=y,
            h=h,
            cy=y + h / 2,
        )
        for name, y, h in (("a", 10.0, 60.0), ("b", 200.0, 60.0))
    ]
    pair = Recording("made", pd.concat(tables, ignore_index=True), 25.0, 640, 480)
    found = compose_all(pair, focal_length=450, shifts=[0])
    assert found.table["rule"].tolist() == [thesis.UNIDENTIFIED]
    assert found.known.tolist() == [False]


def test_who_covers_already_is_left_out(make_walks):
    pair = make_walks(a=(100.0, 3.0), b=(110.0, 3.0), c=(400.0, -3.0))
    table = compose_all(pair, focal_length=450, shifts=[0]).table
    met = list(zip(table["first"], table["second"], strict=True))
    assert met == [("a", "c"), ("b", "c")]


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"shifts": []}, "shifts is empty"),
        ({"shifts": [-1]}, "shifts is -1"),
        ({"shifts": [np.nan]}, "shifts is nan"),
        ({"shifts": [1e9]}, "shift is"),
        ({"shifts": ["1"]}, "shifts is '1'"),
        ({"focal_length": 0}, "focal_length"),
        ({"seconds": 0}, "seconds"),
        ({"seconds": 0.1}, "a direction needs 4"),
        ({"seconds": 30}, "no two walks"),
        ({"shifts": [30]}, "no two walks"),
    ],
)
def test_impossible_wishes_are_refused(make_walks, options, match):
    pair = make_walks(a=(100.0, 3.0), b=(400.0, -3.0))
    with pytest.raises(McnError, match=match):
        compose_all(pair, **{"focal_length": 450, "shifts": [0], **options})


def test_walks_that_the_edge_cuts_have_no_direction(make_boxes):
    edge = make_boxes(5, sequence="a", x=[0.0, 0, 3, 6, 9], cx=[20.0, 20, 23, 26, 29])
    pair = pd.concat([edge, edge.assign(sequence="b", subject="b")], ignore_index=True)
    recording = Recording("made", pair, 5.0, 640, 480)
    with pytest.raises(ArgumentError, match="no two walks"):
        compose_all(recording, focal_length=450, shifts=[0])


def test_one_walk_makes_no_composite(make_walks):
    with pytest.raises(ArgumentError, match="no two walks"):
        compose_all(make_walks(a=(100.0, 3.0)), focal_length=450)
