"""What the figures of the benchmark draw."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb

from mcnlab import plotting
from mcnlab.errors import ArgumentError
from mcnlab.figures.registry import draw
from mcnlab.occlusion import benchmark
from mcnlab.occlusion.pairs import find_pairs, lay_over
from mcnlab.occlusion.scores import reliability_of
from mcnlab.occlusion.thesis import APART, BY_SPEED, CERTAIN, direction_table
from mcnlab.occlusion.truth import cover_of
from mcnlab.plotting.benchmark import (
    describe_recording,
    plot_precision_recall,
    plot_reliability,
    plot_scores,
    plot_shares_by_cell,
    shorten,
)
from mcnlab.plotting.pairs import follow_pair, guess_boxes, guess_cover, pick_forecasts, plot_moment
from mcnlab.plotting.style import FORECAST_COLOURS, FORECAST_LINES, FORECAST_MARKERS
from mcnlab.statistics import Estimate, wilson_interval
from mcnlab.synthetic.crossings import make_crossings
from mcnlab.tables import H, W, X, Y
from mcnlab.vision import recordings

PANELS = ("foresight-scores", "foresight-curves", "foresight-calibration", "foresight-errors")
LONG = "a-sequence-with-a-name-that-is-longer-than-any-margin"


@pytest.fixture(scope="module")
def tables():
    """Three small recordings, one of them by a moving camera."""
    made = {}
    for seed, (name, moving) in enumerate({"one": False, "two": False, LONG: True}.items()):
        held = find_pairs(make_crossings(people=18, seconds=12.0, seed=seed))
        made[name] = benchmark.compare(held, name=name, moving=moving)
    return made


@pytest.fixture(scope="module")
def judged(tables):
    """How the forecasters did."""
    return benchmark.judge(list(tables.values()), draws=40)


def subset(judged, names):
    """The judgement of some recordings only."""
    return replace(
        judged,
        table=judged.table[judged.table["recording"].isin(names)],
        thresholds=judged.thresholds.loc[names],
        moving={name: judged.moving[name] for name in names},
    )


def lines_of(ax):
    """Label → line."""
    return {line.get_label(): line for line in ax.lines}


def texts_of(ax):
    """All that is written on axes."""
    return [text.get_text() for text in ax.texts]


def marks(ax):
    """The triangles where experience disagrees: (column, row) → what it says."""
    held = [line for line in ax.lines if line.get_gid()]
    places = [
        (round(line.get_xdata()[0] - 0.33), round(line.get_ydata()[0] + 0.31)) for line in held
    ]
    return dict(zip(places, held, strict=True))


# scores and errors


@pytest.mark.parametrize(
    ("number", "measures"),
    [("foresight-scores", ("f1", "ap")), ("foresight-errors", ("time_error_s", "place_error"))],
)
def test_marks_and_bars_are_the_scores_and_their_intervals(judged, number, measures):
    axes = draw(number, judged).axes
    for ax, measure in zip(axes, measures, strict=True):
        drawn = lines_of(ax)
        intervals = [held for held in ax.collections if isinstance(held, LineCollection)]
        for method, held in zip(benchmark.METHODS, intervals, strict=True):
            found = [getattr(judged.scores[name, method], measure) for name in judged.recordings]
            assert all(one.low is not None for one in found)
            np.testing.assert_array_equal(drawn[method].get_xdata(), [one.value for one in found])
            ends = [segment[:, 0] for segment in held.get_segments()]
            np.testing.assert_array_equal(ends, [[one.low, one.high] for one in found])
            # Each on the row of its recording.
            rows = np.round(drawn[method].get_ydata())
            np.testing.assert_array_equal(rows, np.arange(len(judged.recordings)))


def test_moving_cameras_stand_last_and_on_grey(judged):
    ax = draw("foresight-scores", judged).axes[0]
    names = [text.get_text() for text in ax.get_yticklabels()]
    assert names == [describe_recording(judged, name) for name in ("one", "two", LONG)]
    assert [", moving camera" in name for name in names] == [False, False, True]
    (band,) = ax.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == (1.5, 2.5)


def test_a_row_says_how_many_pairs_and_how_many_of_them_occlude(judged, tables):
    share = tables["one"]["occludes"].mean()
    said = re.fullmatch(r"one\n(\d+) pairs, ([\d.]+) % occlude", describe_recording(judged, "one"))
    assert int(said[1]) == len(tables["one"])
    assert float(said[2]) == pytest.approx(100 * share, abs=0.5)


def test_a_score_that_does_not_exist_is_said_so(judged):
    none = Estimate(None, None, None, 9)
    held = {**judged.scores}
    held["one", "thesis"] = held["one", "thesis"]._replace(time_error_s=none)
    sure = held["two", "thesis"].time_error_s
    held["two", "thesis"] = held["two", "thesis"]._replace(
        time_error_s=Estimate(sure.value, None, None, 9)
    )
    ax = draw("foresight-errors", replace(judged, scores=held)).axes[0]
    assert texts_of(ax) == ["none"]
    assert len(lines_of(ax)["thesis"].get_xdata()) == 2
    assert len(ax.collections[0].get_segments()) == 1


def test_broad_bars_are_the_middle_half_of_the_errors(judged):
    ax = draw("foresight-errors", judged).axes[0]
    table = judged.of("one")
    said = table["perspective.probability"] >= judged.thresholds.loc["one", "perspective"]
    right = table[said & table["occludes"]]
    low, high = np.percentile((right["perspective.seconds"] - right["seconds"]).abs(), [25, 75])
    assert [low, high] in [list(line.get_xdata()) for line in ax.lines if line.get_lw() == 6]


def test_unknown_measures_are_refused(judged):
    with pytest.raises(ArgumentError, match="measure is 'f2'; pass one of 'precision'"):
        plot_scores(judged, "f2", label="F2")


# curves


def test_the_area_under_a_drawn_curve_is_its_average_precision(judged):
    axes = draw("foresight-curves", judged).axes
    for ax, name in zip(axes, judged.recordings, strict=True):
        stepped = [line for line in ax.lines if line.get_drawstyle() == "steps-pre"]
        for method, line in zip(benchmark.METHODS[1:], stepped, strict=True):
            area = np.sum(np.diff(line.get_xdata()) * line.get_ydata()[1:])
            assert area == pytest.approx(judged.scores[name, method].ap.value)
            assert line.get_color() == FORECAST_COLOURS[method]


def test_points_are_precision_and_recall_at_the_chosen_threshold(judged):
    axes = draw("foresight-curves", judged).axes
    for ax, name in zip(axes, judged.recordings, strict=True):
        for method in benchmark.METHODS:
            point, held = lines_of(ax)[method], judged.scores[name, method]
            assert point.get_xdata() == [pytest.approx(held.recall.value)]
            assert point.get_ydata() == [pytest.approx(held.precision.value)]


def test_nobody_who_says_no_throughout_has_a_point(tables):
    ax = plot_precision_recall(tables["one"], {"thesis": 1.0, "perspective": 1.0})
    probability = tables["one"]["perspective.probability"]
    assert ("perspective" in lines_of(ax)) == (probability.max() >= 1)
    never = tables["one"].assign(**{"perspective.probability": 0.9 * probability})
    ax = plot_precision_recall(never, {"perspective": 1.0})
    assert "perspective" not in lines_of(ax)


def test_lines_of_one_f1_hold_that_f1(tables):
    ax = plot_precision_recall(tables["one"], {})
    for f1, line in zip((0.2, 0.4, 0.6, 0.8), ax.lines, strict=True):
        recall, precision = line.get_data()
        np.testing.assert_allclose(2 * recall * precision / (recall + precision), f1)
    assert texts_of(ax) == ["0.2", "0.4", "0.6", "0.8"]


# calibration


def test_reliability_is_drawn_as_it_is_measured(judged):
    axes = draw("foresight-calibration", judged).axes
    for ax, name in zip(axes, judged.recordings, strict=True):
        table = judged.of(name)
        if table["occludes"].mean() < plotting.benchmark.RARE:
            continue
        for method in benchmark.METHODS[1:]:
            held = reliability_of(table["occludes"], table[f"{method}.probability"])
            many = held[held["n"] >= plotting.benchmark.FEW]
            line = lines_of(ax)[method]
            np.testing.assert_array_equal(line.get_xdata(), many["probability"])
            np.testing.assert_array_equal(line.get_ydata(), many["share"])
        error = judged.scores[name, benchmark.DEFAULT].calibration_error.value
        assert ax.get_title(loc="left").endswith(f"error {error:.3f}")


def test_rare_occlusion_has_logarithmic_axes_and_zero_at_their_edge():
    probability = np.r_[np.full(1000, 0.002), np.full(50, 0.25), np.full(20, 0.95)]
    occludes = np.r_[np.arange(1000) < 3, np.zeros(50), np.arange(20) < 18].astype(bool)
    table = pd.DataFrame({"occludes": occludes, "perspective.probability": probability})
    ax = plot_reliability(table, ["perspective"])
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    line = lines_of(ax)["perspective"]
    np.testing.assert_allclose(line.get_xdata(), [0.002, 0.25, 0.95])
    np.testing.assert_allclose(line.get_ydata(), [0.003, 1e-3, 0.9])
    hollow = [held for held in ax.lines if held.get_markerfacecolor() == "white"]
    assert [list(held.get_xdata()) for held in hollow if len(held.get_xdata())] == [[0.25]]
    bars = [held for held in ax.collections if len(held.get_segments())]
    np.testing.assert_allclose(bars[0].get_segments()[2][:, 1], wilson_interval(0.9, 20))


def test_shares_of_few_pairs_are_pale_and_not_joined():
    few = plotting.benchmark.FEW - 1
    table = pd.DataFrame(
        {
            "occludes": np.r_[np.arange(50) < 20, np.ones(few)].astype(bool),
            "learned.probability": np.r_[np.full(50, 0.45), np.full(few, 0.95)],
        }
    )
    ax = plot_reliability(table, ["learned"])
    assert list(lines_of(ax)["learned"].get_xdata()) == [pytest.approx(0.45)]
    (pale,) = (line for line in ax.lines if line.get_alpha() == 0.3 and len(line.get_xdata()))
    assert (list(pale.get_xdata()), pale.get_linestyle()) == ([pytest.approx(0.95)], "None")


# any recordings


@pytest.mark.parametrize("number", PANELS)
@pytest.mark.parametrize("names", [["one", "two"], ["one", LONG], ["two", "one", LONG]])
def test_any_recordings_can_be_drawn(judged, number, names):
    drawn = draw(number, subset(judged, names))
    drawn.canvas.draw()
    many = {"foresight-curves", "foresight-calibration"}
    assert len(drawn.axes) == (len(names) if number in many else 2)
    (legend,) = drawn.legends
    said = [text.get_text() for text in legend.get_texts()]
    assert said == list(benchmark.METHODS[number == "foresight-calibration" :])


@pytest.mark.parametrize("count", [2, 3, 7, 25])
def test_as_many_recordings_as_there_are_fit(judged, count):
    names = [f"copy-{number}" for number in range(count)]
    table = judged.of("one")
    scores = judged.scores
    many = benchmark.Judged(
        pd.concat([table.assign(recording=name) for name in names]),
        pd.concat([judged.thresholds.loc[["one"]]] * count).set_axis(names),
        {(name, one): scores["one", one] for name in names for one in benchmark.METHODS},
        {},
        dict.fromkeys(names, False),
    )
    drawn = draw("foresight-curves", many)
    titles = [ax.get_title(loc="left").split("\n")[0] for ax in drawn.axes]
    assert titles == names
    # The lowest of each column, and no other, says what it measures.
    lowest = [ax for ax in drawn.axes if ax.get_xlabel()]
    assert len(lowest) == drawn.axes[0].get_subplotspec().get_gridspec().ncols


def test_long_names_lose_their_middle():
    assert shorten("short") == "short"
    cut = shorten(LONG, 20)
    assert len(cut) == 20
    assert LONG.startswith(cut.split("…")[0])
    assert LONG.endswith(cut.split("…")[1])


# the table that experience makes


def test_cells_hold_the_shares_that_were_counted(judged):
    held = benchmark.count_experience(judged.table)
    drawn = draw("learned-table", {"made": held}, least=5)
    pairs, occluding = held.by_direction()
    rule, learned = drawn.axes[0], drawn.axes[3]
    assert [text.get_text() for text in rule.texts] == [
        {APART: "0", CERTAIN: "1", BY_SPEED: "P"}[int(code)] for code in direction_table().ravel()
    ]
    drawn = learned.images[0].get_array()
    np.testing.assert_array_equal(np.ma.getmaskarray(drawn), pairs < 5)
    np.testing.assert_allclose(drawn[pairs >= 5], (occluding / np.maximum(pairs, 1))[pairs >= 5])
    assert not learned.texts
    bar = learned.figure.axes[-1]
    mean = occluding.sum() / pairs.sum()
    assert float(bar.get_xticklabels()[1].get_text().split()[0]) == pytest.approx(100 * mean, abs=1)
    hatched = [patch for patch in learned.patches if patch.get_hatch()]
    assert len(hatched) == (pairs < 5).sum()


def test_speed_tables_stand_below_with_their_side(judged):
    held = benchmark.count_experience(judged.table)
    drawn = draw("learned-table", {"a": held, "b": held})
    assert len(drawn.axes) == 3 * 3 + 2  # the last two are bars of the shades
    for ax, side in zip(drawn.axes[4:6], ("right", "left"), strict=True):
        assert side in ax.get_title(loc="left")
        pairs = held.by_speed(side)[0]
        share = held.by_speed(side)[1] / np.maximum(pairs, 1)
        drawn_shares = ax.images[0].get_array()
        np.testing.assert_allclose(drawn_shares.data[pairs >= 20], share[pairs >= 20])
        assert ax.images[0].norm.vmax == drawn.axes[3].images[0].norm.vmax


def test_cells_that_disagree_with_the_rule_are_marked():
    rule = np.array([[APART, APART, CERTAIN], [CERTAIN, BY_SPEED, APART], [APART, CERTAIN, APART]])
    pairs = np.array([[100, 100, 100], [100, 100, 30], [19, 30, 100]])
    occluding = np.array([[40, 10, 10], [40, 90, 7], [19, 5, 20]])
    ax = plot_shares_by_cell(pairs, occluding, rule, mean=0.2)
    found = {at: (line.get_gid().split()[0], line.get_marker()) for at, line in marks(ax).items()}
    # (3, 3) has the mean itself, (1, 3) too few pairs, and by speed is no wrong answer.
    assert found == {
        (1, 1): ("more", "^"),
        (3, 1): ("fewer", "v"),
        (3, 2): ("more", "^"),
        (2, 3): ("fewer", "v"),
    }
    sure = {at: line.get_markerfacecolor() != "white" for at, line in marks(ax).items()}
    # Wilson: 0.4 of 100 in [0.31, 0.50], 0.1 of 100 in [0.06, 0.17], 7 and 5 of 30 hold 0.2.
    assert sure == {(1, 1): True, (3, 1): True, (3, 2): False, (2, 3): False}


@pytest.mark.parametrize(("some", "mean"), [(0, 0.0), (1, 1.0)])
def test_tables_without_contrast_can_be_drawn(some, mean):
    pairs = np.full((3, 3), 50)
    ax = plot_shares_by_cell(pairs, some * pairs, np.zeros((3, 3)), mean=mean)
    assert np.isfinite(ax.images[0].get_array()).all()
    assert not marks(ax)


def test_impossible_counts_are_refused(judged):
    held = benchmark.count_experience(judged.table)
    rule = direction_table()
    with pytest.raises(ArgumentError, match=r"shapes \(8, 8\), \(8, 8\) and \(3, 3\)"):
        plot_shares_by_cell(*held.by_direction(), np.zeros((3, 3)), mean=0.1)
    pairs, occluding = held.by_direction()
    with pytest.raises(ArgumentError, match="occluding holds more than pairs"):
        plot_shares_by_cell(pairs, pairs + 1, rule, mean=0.1)
    with pytest.raises(ArgumentError, match="least is 0"):
        plot_shares_by_cell(pairs, occluding, rule, mean=0.1, least=0)
    with pytest.raises(ArgumentError, match="experience is empty"):
        draw("learned-table", {})
    nothing = benchmark.Experience(*np.zeros((2, 8, 8, 3, 3), int))
    with pytest.raises(ArgumentError, match="'nobody' holds no pair"):
        draw("learned-table", {"nobody": nothing})


# one pair


def test_a_story_holds_the_boxes_of_the_recording(square, pairs):
    number = int(np.flatnonzero(pairs.occludes)[0])
    story = follow_pair(square, pairs, number)
    for which, seen, boxes in zip(story.order, story.seen, story.boxes, strict=True):
        rows = square.boxes[square.boxes["subject"] == pairs.people[number, which]]
        frames = pairs.frame[number] + np.round(story.seconds * square.frame_rate).astype(int)
        held = rows.set_index("frame")[[X, Y, W, H]].reindex(frames)
        np.testing.assert_array_equal(seen, held[X].notna())
        np.testing.assert_array_equal(boxes, held.fillna(0.0))
    at = story.nearest(0)
    assert story.seconds[at] == 0
    left, right = story.boxes[:, at]
    assert left[0] + left[2] / 2 <= right[0] + right[2] / 2


def test_the_story_tells_what_the_pairs_say(square, pairs):
    for number in range(len(pairs)):
        story = follow_pair(square, pairs, number)
        exceeds = (story.seconds > 0) & (story.cover > pairs.rules.cover)
        assert exceeds.any() == pairs.occludes[number]
        if pairs.occludes[number]:
            assert story.late == pairs.seconds[number] == story.seconds[exceeds][0]
            assert story.place == (pairs.x[number], pairs.y[number])
        else:
            assert story.late is story.place is None


def test_composites_have_stories_too():
    casia = recordings.casia_a()
    some = casia.boxes[casia.boxes["subject"].isin(casia.subjects.unique()[:2])]
    few = casia.with_boxes(some.reset_index(drop=True), directions=None, copies=frozenset())
    pairs = lay_over(few, shifts=(12,))
    apart = np.flatnonzero(pairs.now[:, 0] != pairs.now[:, 1])
    for number in apart[:: max(1, len(apart) // 20)]:
        story = follow_pair(few, pairs, int(number))
        exceeds = (story.seconds > 0) & (story.cover > pairs.rules.cover)
        assert exceeds.any() == pairs.occludes[number]


def test_the_baseline_goes_straight_on_and_the_learned_one_as_the_perspective(pairs):
    number, times = 0, [0.5, 1.0, 1.5]
    boxes = guess_boxes(
        pairs, number, times, ("thesis", "constant-velocity", "perspective", "learned")
    )
    assert set(boxes) == {"constant-velocity", "perspective"}
    straight = boxes["constant-velocity"]
    assert straight.shape == (3, 2, 4)
    middle = straight[..., 0] + straight[..., 2] / 2
    np.testing.assert_allclose(np.diff(middle, 2, axis=0), 0, atol=1e-9)
    alone = guess_boxes(pairs, number, times, ("learned",))
    np.testing.assert_array_equal(alone["learned"], boxes["perspective"])


def test_foreseen_cover_is_that_of_foreseen_boxes(pairs):
    times = [1.0, 2.0]
    cover = guess_cover(pairs, 1, times, ("perspective",))["perspective"]
    for at, boxes in enumerate(guess_boxes(pairs, 1, times, ("perspective",))["perspective"]):
        assert cover[at] == cover_of(*boxes)


def test_a_moment_shows_both_boxes_and_the_feet_until_then(square, pairs):
    number = int(np.flatnonzero(pairs.occludes)[0])
    story = follow_pair(square, pairs, number)
    ax = plot_moment(story, 0.0)
    tracks, boxes = ax.lines[::2], ax.lines[1::2]
    at = story.nearest(0)
    for walker in (0, 1):
        x, y, w, h = story.boxes[walker, at]
        assert set(boxes[walker].get_xdata()) == {x, x + w}
        assert set(boxes[walker].get_ydata()) == {y, y + h}
        assert tracks[walker].get_xdata()[-1] == x + w / 2
        assert tracks[walker].get_ydata()[-1] == y + h
        assert len(tracks[walker].get_xdata()) == story.seen[walker, : at + 1].sum()
    assert boxes[0].get_linestyle() != boxes[1].get_linestyle()


def test_a_pair_is_told_in_four_moments_and_over_time(square, pairs, forecasts):
    number = int(np.flatnonzero(pairs.occludes)[2])
    drawn = draw("foresight-pair", square, pairs, number, forecasts)
    *moments, below = drawn.axes
    titles = [ax.get_title(loc="left") for ax in moments]
    late, said = pairs.seconds[number], forecasts["perspective"].seconds[number]
    told = {f"{said:.1f} s: as perspective foresees": said, f"{late:.1f} s: they occlude": late}
    assert titles[2:] == sorted(told, key=told.get)
    for method, held in forecasts.items():
        mark = [line for line in moments[3].lines if line.get_label() == method][-1]
        assert (mark.get_xdata()[0], mark.get_ydata()[0]) == (held.x[number], held.y[number])
        lane = [line for line in below.lines if line.get_label() == method][-1]
        assert lane.get_xdata()[0] == held.seconds[number]
        yes = held.probability[number] >= 0.5
        word = f"{method}: {'yes' if yes else 'no'}, {held.probability[number]:.2f}"
        assert word in texts_of(below)
        assert (lane.get_markerfacecolor() == "white") == (not yes)
    ring = lines_of(moments[3])["truth"]
    assert (ring.get_xdata()[0], ring.get_ydata()[0]) == (pairs.x[number], pairs.y[number])
    story = follow_pair(square, pairs, number)
    both = story.seen.all(axis=0)
    np.testing.assert_array_equal(lines_of(below)["truth"].get_ydata(), story.cover[both])


def test_a_pair_that_never_occludes_is_followed_to_the_horizon(square, pairs, forecasts):
    number = int(np.flatnonzero(~pairs.occludes)[0])
    only = {"thesis": forecasts["thesis"]}
    drawn = draw("foresight-pair", square, pairs, number, only, thresholds={"thesis": 0.0})
    titles = [ax.get_title(loc="left") for ax in drawn.axes[:4]]
    assert "3.0 s: they do not occlude" in titles
    assert "truth" not in lines_of(drawn.axes[3])
    assert any("thesis: yes" in text for text in texts_of(drawn.axes[4]))


@pytest.mark.parametrize("number", [-1, 1.5, "first"])
def test_a_pair_is_named_by_a_whole_number(square, pairs, number):
    with pytest.raises(ArgumentError, match="number is"):
        follow_pair(square, pairs, number)


def test_pairs_and_forecasts_of_something_else_are_refused(square, pairs, forecasts):
    with pytest.raises(ArgumentError, match=f"number is {len(pairs)}; pass one of 0 to"):
        follow_pair(square, pairs, len(pairs))
    with pytest.raises(ArgumentError, match="recording is 'casia-a'"):
        follow_pair(recordings.casia_a(), pairs, 0)
    with pytest.raises(ArgumentError, match="forecasts is empty"):
        pick_forecasts(pairs, 0, {})
    with pytest.raises(ArgumentError, match="method is 'oracle'"):
        pick_forecasts(pairs, 0, {"oracle": forecasts["thesis"]})
    short = forecasts["thesis"]._replace(x=forecasts["thesis"].x[1:])
    with pytest.raises(ArgumentError, match=r"forecasts\['thesis'\] is not of these"):
        pick_forecasts(pairs, 0, {"thesis": short})


def test_forecasters_are_told_apart_in_grey_by_marker_and_by_line():
    weights = np.array([0.2126, 0.7152, 0.0722])
    grey = sorted(float(weights @ to_rgb(held)) for held in FORECAST_COLOURS.values())
    # A twentieth of the range is about the least step that a print shows.
    assert np.diff(grey).min() > 0.05
    for held in (FORECAST_COLOURS, FORECAST_MARKERS, FORECAST_LINES):
        assert tuple(held) == benchmark.METHODS
        assert len(set(held.values())) == len(held)
