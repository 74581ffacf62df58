"""Counts of what the tables say add up, and scores are shares within their intervals."""

from dataclasses import replace

import pytest

from mcnlab.errors import ArgumentError
from mcnlab.occlusion import thesis, thesis_check


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
