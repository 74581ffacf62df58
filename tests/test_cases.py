"""Composites are judged by their boxes, cases chosen without a look at what happens."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mcnlab import bundled, cases, occlusion
from mcnlab.cases import CASES, Case
from mcnlab.datasets.composites import compose, make_street
from mcnlab.datasets.mirror import SUFFIX, mirror_boxes, mirror_direction
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, McnError


@pytest.fixture(scope="module")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return bundled.casia_a()


@pytest.fixture(scope="module")
def composites(casia):
    """Every composite of CASIA A."""
    return cases.compose_all(casia, focal_length=450)


@pytest.fixture(scope="module")
def street():
    """The made street's composites that begin together."""
    return cases.compose_all(make_street().recording, focal_length=450, shifts=[0])


def some_of(recording, people):
    """The walks of some people."""
    boxes = recording.boxes[recording.boxes["subject"].isin(people)].reset_index(drop=True)
    names = list(boxes["sequence"].unique())
    return recording.with_boxes(
        boxes, directions=recording.directions[names], copies=recording.copies & set(names)
    )


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
    looked_up = occlusion.look_up(
        *(table[f"{what}{who}"] for what in ("direction", "level") for who in (1, 2))
    )
    np.testing.assert_array_equal(table["rule"], looked_up)
    assert (table["said"] == np.isfinite(table["said_seconds"])).all()
    assert table.loc[table["rule"] == occlusion.CERTAIN, "said"].all()
    assert not table.loc[table["rule"] == occlusion.APART, "said"].any()
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
    there = cases.compose_all(twin, focal_length=450, shifts=[0]).table
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


def test_all_six_cases_come_out_right(composites, street):
    for sources in ([composites, street], [street]):
        judged = cases.judge_cases(sources)
        assert judged["figure"].tolist() == [case.figure for case in CASES]
        assert judged["right"].all()
        assert judged["caption"].tolist() == [True] * 5 + [False]
        assert not judged.duplicated(["data", "first", "second"]).any()


def test_cases_have_the_directions_and_levels_of_their_captions(composites, street):
    judged = cases.judge_cases([composites, street]).to_dict("records")
    for case, row in zip(CASES, judged, strict=True):
        assert (row["direction1"], row["direction2"]) == case.directions
        assert case.levels in (None, (row["level1"], row["level2"]))
        assert row["x1"] < row["x2"]
        assert row["shift"] == 0
        assert row["fitting_right"] <= row["fitting"]


def test_nobody_of_casia_a_crosses_the_view_at_v1(composites):
    judged = cases.judge_cases([composites])
    assert judged["figure"].tolist() == ["3.14(a)", "3.14(b)", "3.15(a)", "3.15(b)"]


def test_the_outcome_has_no_say_in_the_choice(composites):
    blind = composites.table.assign(
        occludes=~composites.table["occludes"], seconds=0.0, x=0.0, y=0.0
    )
    for case in CASES[:4]:
        seen = cases.choose_case(composites, case)
        unseen = cases.choose_case(replace(composites, table=blind), case)
        assert (seen["first"], seen["second"]) == (unseen["first"], unseen["second"])


def test_the_farthest_apart_are_chosen_and_none_twice(composites):
    case = CASES[0]
    fitting = composites.table[cases.find_fitting(composites, case)]
    apart = np.hypot(fitting["x2"] - fitting["x1"], fitting["y2"] - fitting["y1"])
    first = cases.choose_case(composites, case)
    assert first.name == apart.idxmax()
    taken = [(first["first"], first["second"])]
    second = cases.choose_case(composites, case, taken=taken)
    assert second.name == apart.drop(first.name).idxmax()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_any_subset_of_people_will_do(casia, street, count):
    people = sorted(casia.subjects.unique())[-count:]
    few = cases.compose_all(some_of(casia, people), focal_length=450)
    assert cases.judge_cases([few, street])["figure"].tolist() == [case.figure for case in CASES]
    judged = cases.judge_table(few)
    assert judged["right"].n == count
    assert (judged["right"].low is None) == (count < 3)
    assert cases.count_cells(few)["n"].sum() == len(few.table)


def test_counts_add_up(composites):
    table, cells = composites.table, cases.count_cells(composites)
    assert len(cells) == 64
    assert cells["n"].sum() == len(table)
    assert cells["occluded"].sum() == table["occludes"].sum()
    assert cells["right"].sum() == (table["said"] == table["occludes"]).sum()
    cell = cells[(cells["direction1"] == 3) & (cells["direction2"] == 7)].iloc[0]
    own = table[(table["direction1"] == 3) & (table["direction2"] == 7)]
    assert (cell["printed"], cell["n"]) == (occlusion.CERTAIN, len(own))
    assert cell["occluded"] == own["occludes"].sum()
    rules = cases.count_rules(composites)
    assert rules["n"].sum() == len(table)
    assert rules["hits"].sum() == (table["said"] & table["occludes"]).sum()
    assert rules["share"].sum() == pytest.approx(1)


def test_every_error_has_one_reason(composites):
    table, why = composites.table, cases.explain_errors(composites)
    assert why["false yes"] == (table["said"] & ~table["occludes"]).sum()
    assert why["false yes"] == why["video ends first"] + why["miss in time"]
    assert why["missed"] == (~table["said"] & table["occludes"]).sum()
    reasons = ("levels alike", "one ahead faster", "departing", "out of frame")
    assert why["missed"] == sum(why[name] for name in reasons)


def test_scores_are_plain_shares_within_their_intervals(composites):
    table = composites.table
    judged = cases.judge_table(composites)
    hits = (table["said"] & table["occludes"]).sum()
    assert judged["right"].value == pytest.approx((table["said"] == table["occludes"]).mean())
    assert judged["precision"].value == pytest.approx(hits / table["said"].sum())
    assert judged["recall"].value == pytest.approx(hits / table["occludes"].sum())
    for estimate in judged.values():
        assert estimate.low < estimate.value < estimate.high
        assert estimate.n == composites.recording.subjects.nunique()
    in_time = cases.judge_table(composites, in_time=True)
    late = table["said_seconds"] > table["left"]
    said = (table["said"] & ~late).sum()
    assert in_time["precision"].value == pytest.approx(
        (table["said"] & ~late & table["occludes"]).sum() / said
    )


def made(make_boxes, **walks):
    """A recording of straight walks: name → (x of the centre at first, pixels a frame)."""
    tables = [
        make_boxes(
            60,
            sequence=name,
            subject=name,
            x=x + step * np.arange(60) - 20,
            w=40.0,
            h=100.0,
            cx=x + step * np.arange(60),
            cy=110.0,
        )
        for name, (x, step) in walks.items()
    ]
    return Recording("made", pd.concat(tables, ignore_index=True), 25.0, 640, 480)


def test_a_meeting_head_on_is_foreseen_to_the_frame(make_boxes):
    pair = made(make_boxes, a=(100.0, 3.0), b=(400.0, -3.0))
    row = cases.compose_all(pair, focal_length=450, shifts=[0]).table.iloc[0]
    # 300 px apart less 2 · 24 · 3 seen, at 2 · 75 px/s.
    assert row["said_seconds"] == pytest.approx(156 / 150)
    assert row["said_x"] == pytest.approx(250)
    # More than 12 of 40 px shared: less than 28 apart, 129 of 156 px later, by 6 a frame.
    assert row["seconds"] == pytest.approx(22 / 25)
    assert (row["direction1"], row["direction2"], row["rule"]) == (3, 7, occlusion.CERTAIN)


def test_the_order_of_the_walks_says_nothing(make_boxes):
    walks = {"a": (100.0, 3.0), "b": (400.0, -3.0)}
    one = cases.compose_all(made(make_boxes, **walks), focal_length=450, shifts=[0])
    turned = dict(reversed(walks.items()))
    other = cases.compose_all(made(make_boxes, **turned), focal_length=450, shifts=[0])
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
    found = cases.compose_all(pair, focal_length=450, shifts=[0])
    assert found.table["rule"].tolist() == [occlusion.UNIDENTIFIED]
    assert cases.count_cells(found)["n"].sum() == 0
    assert cases.choose_case(found, Case("made", (3, 3), None, False)) is None
    with pytest.raises(ArgumentError, match="no composite"):
        cases.judge_table(found)


def test_who_covers_already_is_left_out(make_boxes):
    pair = made(make_boxes, a=(100.0, 3.0), b=(110.0, 3.0), c=(400.0, -3.0))
    table = cases.compose_all(pair, focal_length=450, shifts=[0]).table
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
def test_impossible_wishes_are_refused(make_boxes, options, match):
    pair = made(make_boxes, a=(100.0, 3.0), b=(400.0, -3.0))
    with pytest.raises(McnError, match=match):
        cases.compose_all(pair, **{"focal_length": 450, "shifts": [0], **options})


def test_walks_that_the_edge_cuts_have_no_direction(make_boxes):
    edge = make_boxes(5, sequence="a", x=[0.0, 0, 3, 6, 9], cx=[20.0, 20, 23, 26, 29])
    pair = pd.concat([edge, edge.assign(sequence="b", subject="b")], ignore_index=True)
    recording = Recording("made", pair, 5.0, 640, 480)
    with pytest.raises(ArgumentError, match="no two walks"):
        cases.compose_all(recording, focal_length=450, shifts=[0])


def test_one_walk_makes_no_composite(make_boxes):
    with pytest.raises(ArgumentError, match="no two walks"):
        cases.compose_all(made(make_boxes, a=(100.0, 3.0)), focal_length=450)


def test_no_source_with_any_case_is_refused(make_boxes):
    pair = made(make_boxes, a=(100.0, -1.0), b=(400.0, 1.0))
    parting = cases.compose_all(pair, focal_length=450, shifts=[0])
    for sources in ([parting], []):
        with pytest.raises(ArgumentError, match="no composite fits"):
            cases.judge_cases(sources)


def test_silhouettes_fill_their_boxes(street):
    name = "s01-d6"
    masks = cases.silhouettes_of(street.recording, name, [1, 50])
    walk = street.recording.sequence(name).set_index("frame")
    for mask, frame in zip(masks, (1, 50), strict=True):
        rows, columns = np.nonzero(mask)
        box = walk.loc[frame]
        assert (columns.min(), rows.min()) == (box["x"], box["y"])
        assert (np.ptp(columns) + 1, np.ptp(rows) + 1) == (box["w"], box["h"])
        assert len(rows) == box["area"]


def test_without_images_there_are_no_silhouettes(casia):
    assert cases.silhouettes_of(casia, casia.sequences[0], [1]) is None


def test_real_silhouettes_lie_in_their_boxes(recordings, monkeypatch):
    monkeypatch.setenv(bundled.VARIABLE, str(recordings))
    held = bundled.casia_a_folder()
    if held is None:
        pytest.skip("no CASIA A silhouettes")
    casia = bundled.read_casia_a(bundled.BUNDLED / "casia-a")
    present = {path.name for path in (held / "silhouettes").iterdir()}
    name = next(name for name in casia.sequences if casia.subjects[name] in present)
    box = casia.sequence(name).iloc[30]
    for sequence, left in ((name, box["x"]), (name + SUFFIX, 352 - box["x"] - box["w"])):
        (mask,) = cases.silhouettes_of(casia, sequence, [box["frame"]])
        columns = np.flatnonzero(mask.any(axis=0))
        # The bundled boxes are mended where fragments came off; the middle is within both.
        assert left - 3 <= columns.min() < columns.max() <= left + box["w"] + 2
