"""The panels of the benchmark say what is scored, and what happens to a pair."""

import re
from dataclasses import replace

import ipywidgets
import numpy as np
import pytest

from mcnlab import widgets
from mcnlab.errors import ArgumentError
from mcnlab.occlusion import benchmark
from mcnlab.occlusion.forecasters import Perspective
from mcnlab.occlusion.pairs import Rules, find_pairs
from mcnlab.occlusion.scores import average_precision, count_answers
from mcnlab.synthetic.crossings import make_crossings
from mcnlab.vision import recordings
from mcnlab.widgets.benchmark import interesting


@pytest.fixture(scope="module")
def judged():
    """How the forecasters did on two small recordings."""
    made = [
        benchmark.compare(find_pairs(make_crossings(people=18, seconds=12.0, seed=seed)), name=name)
        for seed, name in enumerate(("one", "two"))
    ]
    return benchmark.judge(made, draws=40)


def moved(panel, **values):
    """The pictures after each of some moves, one control after the other."""
    pictures = []
    for name, value in values.items():
        panel.controls[name].value = value
        pictures.append(bytes(panel.picture.value))
        assert pictures[-1].startswith(b"\x89PNG")
    return pictures


def numbers_in(panel):
    """What a panel says in bold."""
    return [float(value) for value in re.findall(r"<b>([\d.]+)", panel.text.value)]


def test_the_threshold_panel_says_what_is_scored(judged):
    panel = widgets.threshold_panel(judged)
    assert panel.controls["recording"].options == tuple(judged.recordings)
    for method in benchmark.METHODS:
        panel.controls["method"].value = method
        panel.controls["threshold"].value = 0.3
        table = judged.of("one")
        found = count_answers(table["occludes"], table[f"{method}.probability"], 0.3)
        *counts, f1 = numbers_in(panel)
        assert counts == [found.hits, found.misses, found.false_alarms]
        assert f1 == round(found.f1, 3)


def test_the_threshold_panel_follows(judged):
    panel = widgets.threshold_panel(judged)
    moves = {"recording": "two", "method": "constant-velocity", "threshold": 0.9}
    assert len(set(moved(panel, **moves))) == 3


def test_the_threshold_panel_says_when_nobody_is_told_yes(judged):
    table = judged.table.assign(**{"learned.probability": 0.9 * judged.table["occludes"]})
    panel = widgets.threshold_panel(replace(judged, table=table))
    panel.controls["threshold"].value = 0.95
    assert "precision none, recall 0.00" in panel.text.value


def test_the_rules_panel_finds_pairs_anew(square):
    panel = widgets.rules_panel(square)
    moves = {"observed": 0.6, "horizon": 2.0, "cover": 0.5}
    assert len(set(moved(panel, **moves))) == 3
    held = find_pairs(square, rules=Rules(observed=0.6, horizon=2.0, cover=0.5))
    probability = Perspective().forecast(held).probability
    assert panel.text.value.startswith(f"{len(held)} pairs, <b>{held.occludes.mean():.1%}</b>")
    found = count_answers(held.occludes, probability, 0.5)
    precise = average_precision(held.occludes, probability)
    assert numbers_in(panel)[-2:] == [round(found.f1, 2), round(precise, 2)]


def test_the_rules_panel_has_people_of_its_own():
    panel = widgets.rules_panel()
    assert re.match(r"\d+ pairs, <b>[\d.]+%</b> occlude; constant-velocity", panel.text.value)


def test_the_rules_panel_says_where_nothing_is_left(square):
    short = square.boxes[square.boxes["frame"] <= 60].reset_index(drop=True)
    panel = widgets.rules_panel(square.with_boxes(short))
    # Of 2.4 s, 1.4 s can be followed: less than 60 % of 3 s, more than of 1 s.
    assert panel.text.value.startswith("<b>DatasetError</b>: crossings holds no pair")
    panel.controls["horizon"].value = 1.0
    assert "pairs, <b>" in panel.text.value
    with pytest.raises(ArgumentError, match="threshold is 2"):
        widgets.rules_panel(square, threshold=2)


def test_the_rules_panel_says_when_nobody_occludes(square, pairs):
    ever = {tuple(two) for two in pairs.people[pairs.occludes]}
    never = next(tuple(two) for two in pairs.people if tuple(two) not in ever)
    few = square.boxes[square.boxes["subject"].isin(never)].reset_index(drop=True)
    panel = widgets.rules_panel(square.with_boxes(few))
    assert "<b>0.0%</b> occlude: nothing to foresee" in panel.text.value


def test_the_pair_panel_leafs_and_walks_on(square, pairs, forecasts):
    panel = widgets.pair_panel(square, pairs, forecasts)
    assert len(set(moved(panel, place=2, seconds=1.5))) == 2
    number = int(interesting(pairs, forecasts)[1])
    said = panel.text.value
    assert said.startswith(f"frame {pairs.frame[number]}, walkers ")
    assert all(person in said for person in pairs.people[number])
    assert (f"<b>{pairs.seconds[number]:.2f} s</b>" in said) == bool(pairs.occludes[number])


def test_interesting_pairs_come_first(pairs, forecasts):
    order = interesting(pairs, forecasts)
    assert sorted(order) == list(range(len(pairs)))
    worth = (pairs.occludes | (forecasts["perspective"].probability >= 0.5))[order]
    assert (np.diff(worth.astype(int)) <= 0).all()
    assert 0 < worth.sum() < len(worth)
    assert (np.diff(pairs.body[order][worth]) <= 0).all()


def test_the_play_button_moves_the_clock(square, pairs):
    panel = widgets.pair_panel(square, pairs, most=5)
    play = panel.children[0]
    assert isinstance(play, ipywidgets.Play)
    assert panel.controls["place"].max == 5
    before = bytes(panel.picture.value)
    play.value = 12
    assert panel.controls["seconds"].value == pytest.approx(1.2)
    assert bytes(panel.picture.value) != before
    panel.controls["seconds"].value = -0.5
    assert play.value == -5
    assert (play.min, play.max) == (-10, 30)


def test_the_pair_panel_wants_the_pairs_own_recording(square, pairs, forecasts):
    with pytest.raises(ArgumentError, match="pass the recording that they were found in"):
        widgets.pair_panel(recordings.casia_a(), pairs)
    with pytest.raises(ArgumentError, match="most is 0"):
        widgets.pair_panel(square, pairs, forecasts, most=0)
