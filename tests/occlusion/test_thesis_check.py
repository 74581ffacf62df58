"""Each case has the composite that its caption asks for, chosen without a look at what happens."""

from dataclasses import replace

import numpy as np
import pytest

from mcnlab.datasets import catalogue
from mcnlab.datasets.mirror import SUFFIX
from mcnlab.errors import ArgumentError
from mcnlab.occlusion import thesis, thesis_check
from mcnlab.occlusion.composites import compose_all
from mcnlab.occlusion.thesis_check import CASES
from mcnlab.vision.recordings import read_casia_a, silhouettes_of


def some_of(recording, people):
    """The walks of some people."""
    boxes = recording.boxes[recording.boxes["subject"].isin(people)].reset_index(drop=True)
    names = list(boxes["sequence"].unique())
    return recording.with_boxes(
        boxes, directions=recording.directions[names], copies=recording.copies & set(names)
    )


def test_all_six_cases_come_out_right(composites, street):
    for sources in ([composites, street], [street]):
        judged = thesis_check.judge_cases(sources)
        assert judged["figure"].tolist() == [case.figure for case in CASES]
        assert judged["right"].all()
        assert judged["caption"].tolist() == [True] * 5 + [False]
        assert not judged.duplicated(["data", "first", "second"]).any()


def test_cases_have_the_directions_and_levels_of_their_captions(composites, street):
    judged = thesis_check.judge_cases([composites, street]).to_dict("records")
    for case, row in zip(CASES, judged, strict=True):
        assert (row["direction1"], row["direction2"]) == case.directions
        assert case.levels in (None, (row["level1"], row["level2"]))
        assert row["x1"] < row["x2"]
        assert row["shift"] == 0
        assert row["fitting_right"] <= row["fitting"]


def test_nobody_of_casia_a_crosses_the_view_at_v1(composites):
    judged = thesis_check.judge_cases([composites])
    assert judged["figure"].tolist() == ["3.14(a)", "3.14(b)", "3.15(a)", "3.15(b)"]


def test_the_outcome_has_no_say_in_the_choice(composites):
    blind = composites.table.assign(
        occludes=~composites.table["occludes"], seconds=0.0, x=0.0, y=0.0
    )
    for case in CASES[:4]:
        seen = thesis_check.choose_case(composites, case)
        unseen = thesis_check.choose_case(replace(composites, table=blind), case)
        assert (seen["first"], seen["second"]) == (unseen["first"], unseen["second"])


def test_the_farthest_apart_are_chosen_and_none_twice(composites):
    case = CASES[0]
    fitting = composites.table[thesis_check.find_fitting(composites, case)]
    apart = np.hypot(fitting["x2"] - fitting["x1"], fitting["y2"] - fitting["y1"])
    first = thesis_check.choose_case(composites, case)
    assert first.name == apart.idxmax()
    taken = [(first["first"], first["second"])]
    second = thesis_check.choose_case(composites, case, taken=taken)
    assert second.name == apart.drop(first.name).idxmax()


def test_who_is_not_told_apart_stands_for_no_case(street):
    nobody = replace(street, table=street.table.assign(rule=thesis.UNIDENTIFIED))
    for case in CASES:
        assert thesis_check.choose_case(nobody, case) is None


@pytest.mark.parametrize("count", [1, 2, 3])
def test_any_subset_of_people_will_do(casia, street, count):
    people = sorted(casia.subjects.unique())[-count:]
    few = compose_all(some_of(casia, people), focal_length=450)
    assert thesis_check.judge_cases([few, street])["figure"].tolist() == [
        case.figure for case in CASES
    ]
    judged = thesis_check.judge_table(few)
    assert judged["right"].n == count
    assert (judged["right"].low is None) == (count < 3)
    assert thesis_check.count_cells(few)["n"].sum() == len(few.table)


def test_no_source_with_any_case_is_refused(make_walks):
    pair = make_walks(a=(100.0, -1.0), b=(400.0, 1.0))
    parting = compose_all(pair, focal_length=450, shifts=[0])
    for sources in ([parting], []):
        with pytest.raises(ArgumentError, match="no composite fits"):
            thesis_check.judge_cases(sources)


def test_silhouettes_fill_their_boxes(street):
    name = "s01-d6"
    masks = silhouettes_of(street.recording, name, [1, 50])
    walk = street.recording.sequence(name).set_index("frame")
    for mask, frame in zip(masks, (1, 50), strict=True):
        rows, columns = np.nonzero(mask)
        box = walk.loc[frame]
        assert (columns.min(), rows.min()) == (box["x"], box["y"])
        assert (np.ptp(columns) + 1, np.ptp(rows) + 1) == (box["w"], box["h"])
        assert len(rows) == box["area"]


def test_without_images_there_are_no_silhouettes(casia):
    assert silhouettes_of(casia, casia.sequences[0], [1]) is None


def test_real_silhouettes_lie_in_their_boxes(recordings, monkeypatch):
    monkeypatch.setenv(catalogue.VARIABLE, str(recordings))
    held = catalogue.casia_a_folder()
    if held is None:
        pytest.skip("no CASIA A silhouettes")
    casia = read_casia_a(catalogue.BUNDLED / "casia-a")
    present = {path.name for path in (held / "silhouettes").iterdir()}
    name = next(name for name in casia.sequences if casia.subjects[name] in present)
    box = casia.sequence(name).iloc[30]
    for sequence, left in ((name, box["x"]), (name + SUFFIX, 352 - box["x"] - box["w"])):
        (mask,) = silhouettes_of(casia, sequence, [box["frame"]])
        columns = np.flatnonzero(mask.any(axis=0))
        # The bundled boxes are mended where fragments came off; the middle is within both.
        assert left - 3 <= columns.min() < columns.max() <= left + box["w"] + 2


# The tables over all composites


def test_counts_add_up(composites):
    table, cells = composites.table, thesis_check.count_cells(composites)
    assert len(cells) == 64
    assert cells["n"].sum() == len(table)
    assert cells["occluded"].sum() == table["occludes"].sum()
    assert cells["right"].sum() == (table["said"] == table["occludes"]).sum()
    cell = cells[(cells["direction1"] == 3) & (cells["direction2"] == 7)].iloc[0]
    own = table[(table["direction1"] == 3) & (table["direction2"] == 7)]
    assert (cell["printed"], cell["n"]) == (thesis.CERTAIN, len(own))
    assert cell["occluded"] == own["occludes"].sum()
    rules = thesis_check.count_rules(composites)
    assert rules["n"].sum() == len(table)
    assert rules["hits"].sum() == (table["said"] & table["occludes"]).sum()
    assert rules["share"].sum() == pytest.approx(1)


def test_every_error_has_one_reason(composites):
    table, why = composites.table, thesis_check.explain_errors(composites)
    assert why["false yes"] == (table["said"] & ~table["occludes"]).sum()
    assert why["false yes"] == why["video ends first"] + why["miss in time"]
    assert why["missed"] == (~table["said"] & table["occludes"]).sum()
    reasons = ("levels alike", "one ahead faster", "departing", "out of frame")
    assert why["missed"] == sum(why[name] for name in reasons)


def test_scores_are_plain_shares_within_their_intervals(composites):
    table = composites.table
    judged = thesis_check.judge_table(composites)
    hits = (table["said"] & table["occludes"]).sum()
    assert judged["right"].value == pytest.approx((table["said"] == table["occludes"]).mean())
    assert judged["precision"].value == pytest.approx(hits / table["said"].sum())
    assert judged["recall"].value == pytest.approx(hits / table["occludes"].sum())
    for estimate in judged.values():
        assert estimate.low < estimate.value < estimate.high
        assert estimate.n == composites.recording.subjects.nunique()
    in_time = thesis_check.judge_table(composites, in_time=True)
    late = table["said_seconds"] > table["left"]
    said = (table["said"] & ~late).sum()
    assert in_time["precision"].value == pytest.approx(
        (table["said"] & ~late & table["occludes"]).sum() / said
    )


def test_who_is_not_told_apart_is_not_counted(street):
    nobody = replace(street, table=street.table.assign(rule=thesis.UNIDENTIFIED))
    assert thesis_check.count_cells(nobody)["n"].sum() == 0
    with pytest.raises(ArgumentError, match="no composite"):
        thesis_check.judge_table(nobody)
