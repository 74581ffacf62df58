"""The benchmark: nothing of what is judged is learned from, whoever it is filed under."""

import numpy as np
import pandas as pd
import pytest
from sklearn.linear_model import LogisticRegression

from mcnlab.errors import ArgumentError, McnError
from mcnlab.occlusion import benchmark
from mcnlab.occlusion import benchmark as foresight
from mcnlab.occlusion.benchmark import (
    DEFAULT,
    METHODS,
    MOST,
    choose_threshold,
    compare,
    compare_sequences,
    count_experience,
    forecast_of,
    judge,
    learn,
    truth_of,
    with_learned,
)
from mcnlab.occlusion.forecasters import FEATURES
from mcnlab.occlusion.pairs import find_pairs
from mcnlab.occlusion.scores import score
from mcnlab.occlusion.thesis import APART, BY_SPEED, CERTAIN, look_up
from mcnlab.synthetic.crossings import make_crossings

TRUTH = ("occludes", "seconds")
LEARNED = "learned.probability"


def make_table(name, seed, *, moving=False):
    made = make_crossings(people=14, seconds=12.0, seed=seed)
    return compare(find_pairs(made), name=name, moving=moving)


@pytest.fixture(scope="module")
def tables():
    return [make_table(name, seed) for seed, name in enumerate(("north", "east", "south"), 20)]


@pytest.fixture(scope="module")
def judged(tables):
    return judge(tables, draws=20)


def said_of(judged, name):
    return judged.of(name)[LEARNED].to_numpy()


def same_answers(one, two, names):
    """Whether thresholds and learned probabilities of recordings are equal in both."""
    return all(
        one.thresholds.loc[name].equals(two.thresholds.loc[name])
        and np.array_equal(said_of(one, name), said_of(two, name))
        for name in names
    )


def replaced(tables, at, **columns):
    return [table.assign(**columns) if k == at else table for k, table in enumerate(tables)]


def test_the_truth_of_what_is_judged_changes_nothing(tables, judged):
    # North's truth is turned round, and so is what it would teach.
    turned = replaced(tables, 0, occludes=~tables[0]["occludes"], seconds=1.5)
    again = judge(turned, draws=2)
    assert same_answers(judged, again, ["north"])
    # The others do learn from it.
    assert not same_answers(judged, again, ["east"])
    assert not same_answers(judged, again, ["south"])


def test_no_forecast_of_what_is_judged_enters_its_thresholds(tables, judged):
    other = {f"{name}.probability": 0.5 for name in METHODS[:3]}
    again = judge(replaced(tables, 1, **other), draws=2)
    assert again.thresholds.loc["east"].equals(judged.thresholds.loc["east"])
    assert not again.thresholds.loc["north"].equals(judged.thresholds.loc["north"])


def test_what_is_judged_is_what_the_others_taught(tables, judged):
    model = learn(tables[1:])
    taught = [with_learned(table, model) for table in tables]
    assert np.array_equal(said_of(judged, "north"), taught[0][LEARNED])
    for method in METHODS:
        threshold = choose_threshold(taught[1:], method)
        assert judged.thresholds.loc["north", method] == threshold
        scores = score(
            truth_of(taught[0]), forecast_of(taught[0], method), threshold=threshold, draws=20
        )
        assert judged.scores["north", method] == scores
    gain = judged.gains["north", "thesis"]
    ours, theirs = (judged.scores["north", method] for method in (DEFAULT, "thesis"))
    assert gain.f1.value == pytest.approx(ours.f1.value - theirs.f1.value)
    assert gain.ap.value == pytest.approx(ours.ap.value - theirs.ap.value)


def test_recordings_of_the_same_people_are_left_out_together(tables):
    # The same people twice, the second time under another name and with the truth turned
    # round: what it teaches would show.
    first, copy, *others = (
        tables[0].assign(recording="mot17-02-frcnn"),
        tables[0].assign(recording="venice-2", occludes=~tables[0]["occludes"]),
        *tables[1:],
    )
    alone, together = judge([first, *others], draws=2), judge([first, copy, *others], draws=2)
    assert same_answers(alone, together, ["mot17-02-frcnn"])
    assert not same_answers(alone, together, ["east"])


def test_recordings_of_the_same_people_teach_as_much_as_one(tables):
    first = tables[0].assign(recording="mot17-02-frcnn")
    copies = [tables[0].assign(recording=f"mot17-02-{name}") for name in ("dpm", "sdp")]
    one, three = learn([first, tables[1]]), learn([first, *copies, tables[1]])
    # The same sums but for rounding; the solver stops at gradients of 1e-4.
    np.testing.assert_allclose(one.coef_, three.coef_, atol=2e-3)
    np.testing.assert_allclose(one.mean_, three.mean_)
    for method in METHODS[:3]:
        alone = choose_threshold([first, tables[1]], method)
        assert choose_threshold([first, *copies, tables[1]], method) == alone


def test_a_moving_camera_is_scored_and_teaches_nothing(tables, judged):
    moving = make_table("moving", 30, moving=True)
    again = judge([moving, *tables], draws=2)
    assert same_answers(judged, again, ["north", "east", "south"])
    assert again.moving == {"moving": True, "north": False, "east": False, "south": False}
    assert again.recordings == ["north", "east", "south", "moving"]
    assert again.static == ["north", "east", "south"]
    assert again.scores["moving", DEFAULT].ap.value > 0
    assert again.mean(DEFAULT, "f1") == pytest.approx(judged.mean(DEFAULT, "f1"))
    # It is judged by what all the static ones teach.
    assert np.array_equal(said_of(again, "moving"), with_learned(moving, learn(tables))[LEARNED])


def test_the_table_holds_every_pair_once(tables, judged):
    assert len(judged.table) == sum(map(len, tables))
    for table in tables:
        name = table["recording"].iloc[0]
        held = judged.of(name)
        assert held[table.columns].reset_index(drop=True).equals(table)
        assert held[LEARNED].between(0, 1).all()
        assert (held.loc[~held["near"], LEARNED] == 0).all()
        for value in ("seconds", "place_error"):
            assert (held[f"learned.{value}"] == held[f"perspective.{value}"]).all()
    assert judged.thresholds.index.tolist() == ["north", "east", "south"]
    assert judged.thresholds.columns.tolist() == list(METHODS)
    assert ((judged.thresholds >= 0) & (judged.thresholds <= 1)).all().all()


def test_the_mean_is_over_unmoved_recordings_that_have_a_value(judged):
    values = [judged.scores[name, "thesis"].f1.value for name in judged.static]
    assert judged.mean("thesis", "f1") == pytest.approx(np.mean(values))
    nothing = judged.scores["north", "thesis"]._replace(
        time_error_s=judged.scores["north", "thesis"].f1._replace(value=None)
    )
    scores = {**judged.scores, ("north", "thesis"): nothing}
    fewer = benchmark.Judged(judged.table, judged.thresholds, scores, judged.gains, judged.moving)
    values = [judged.scores[name, "thesis"].time_error_s.value for name in ("east", "south")]
    assert fewer.mean("thesis", "time_error_s") == pytest.approx(np.mean(values))
    scores = {key: nothing for key in judged.scores}
    none = benchmark.Judged(judged.table, judged.thresholds, scores, judged.gains, judged.moving)
    assert none.mean("thesis", "time_error_s") is None


def test_judging_twice_gives_the_same(tables, judged):
    again = judge(tables, draws=20)
    assert again.table.equals(judged.table)
    assert again.thresholds.equals(judged.thresholds)
    assert again.scores == judged.scores
    assert again.gains == judged.gains
    # The order of the recordings changes no answer; the solver stops at gradients of 1e-4.
    back = judge(tables[::-1], draws=2)
    for name in judged.recordings:
        np.testing.assert_allclose(said_of(back, name), said_of(judged, name), atol=1e-3)


def test_a_recording_without_an_occlusion_is_left_out(tables, judged):
    quiet = tables[0].assign(recording="quiet", occludes=False)
    again = judge([quiet, *tables], draws=2)
    assert "quiet" not in again.recordings
    assert same_answers(judged, again, judged.recordings)


def test_learning_weighs_recordings_down_to_most(tables, monkeypatch):
    monkeypatch.setattr(foresight, "MOST", 100)
    near = [table[table["near"]] for table in tables[:2]]
    assert all(len(table) > 100 for table in near)
    weights = np.concatenate([np.full(len(table), 100 / len(table)) for table in near])
    values = pd.concat(near)
    features = values[list(FEATURES)].to_numpy()
    mean = np.average(features, axis=0, weights=weights)
    scale = np.sqrt(np.average((features - mean) ** 2, axis=0, weights=weights))
    by_hand = LogisticRegression(C=0.05, max_iter=1000).fit(
        (features - mean) / scale, values["occludes"], sample_weight=weights
    )
    model = learn(tables[:2])
    np.testing.assert_allclose(model.coef_, by_hand.coef_[0], atol=1e-6)
    assert MOST > 100


def test_far_pairs_teach_nothing(tables):
    far = ~tables[0]["near"]
    assert far.any()
    other = tables[0].assign(occludes=tables[0]["occludes"] ^ far)
    assert (learn([other, tables[1]]).coef_ == learn(tables[:2]).coef_).all()


def test_thresholds_count_recordings_by_their_people():
    def table(name, people, occludes, probability):
        return pd.DataFrame(
            {
                "recording": name,
                "first": [f"{k % people}" for k in range(len(occludes))],
                "second": [f"{(k + 1) % people}" for k in range(len(occludes))],
                "occludes": occludes,
                "thesis.probability": probability,
            }
        )

    # One recording wants 0.9 to be no, the other wants 0.4 to be yes.
    strict = ([True, False, False, False], [0.95, 0.9, 0.85, 0.3])
    mild = ([True, True, False, True], [0.9, 0.45, 0.2, 0.4])
    many, few = table("many", 4, *strict), table("few", 2, *mild)
    assert choose_threshold([many, few], "thesis") < 0.9
    assert choose_threshold([many.assign(recording="a"), few], "thesis") == choose_threshold(
        [few, many], "thesis"
    )
    crowd = pd.concat([table("many", 40, *strict)] * 10, ignore_index=True)
    crowd["first"] = [f"{k}" for k in range(40)]
    crowd["second"] = [f"{k + 1}" for k in range(40)]
    assert choose_threshold([crowd, few], "thesis") > 0.9


def broken(tables, kind):
    north, east, _ = tables
    return {
        "none": [],
        "one": [north],
        "one place": [
            north.assign(recording="mot17-04-frcnn"),
            east.assign(recording="mot16-04"),
        ],
        "one still": [north, east.assign(moving=True)],
        "one occludes": [north, east.assign(occludes=False)],
        "twice": [north, east, east],
        "mixed": [pd.concat([north, east]), east],
        "column": [north.drop(columns="moving"), east],
        "feature": [north.drop(columns="gap"), east],
        "no table": [north, None],
        "not finite": [north.assign(gap=np.nan), east],
        "all": [north.assign(occludes=True), east],
    }[kind]


@pytest.mark.parametrize(
    ("kind", "match"),
    [
        ("none", "tables hold no pair that occludes"),
        ("one", "nothing to learn from for"),
        ("one place", "takes another place.*that an unmoved camera filmed"),
        ("one still", "nothing to learn from for"),
        ("one occludes", "nothing to learn from for"),
        ("twice", "tables hold a recording twice"),
        ("mixed", "two recordings in one"),
        ("column", "tables lacks the column.*moving"),
        ("feature", "tables lacks the column.*gap"),
        ("no table", "tables is a NoneType"),
        ("not finite", "features is nan in row"),
        ("all", "answers"),
    ],
)
def test_tables_that_cannot_be_judged_are_refused(tables, kind, match):
    with pytest.raises(McnError, match=match):
        judge(broken(tables, kind), draws=2)


def test_other_recordings_may_teach_without_being_scored(tables):
    first, *others = tables
    alone = judge([first], also=others, draws=2)
    together = judge(tables, draws=2)
    name = first["recording"].iloc[0]
    assert alone.recordings == [name]
    assert alone.thresholds.loc[name].equals(together.thresholds.loc[name])
    assert alone.scores[name, "learned"].f1.value == together.scores[name, "learned"].f1.value
    # Of a place that is at hand, the recording at hand counts, and it alone.
    changed = first.assign(occludes=~first["occludes"])
    assert judge([first], also=[changed, *others], draws=2).thresholds.equals(alone.thresholds)


def test_a_recording_without_occlusions_is_named(tables):
    calm = tables[0].assign(occludes=False, recording="calm")
    judged = judge([*tables, calm], draws=2)
    (said,) = judged.left_out
    assert said.startswith("calm was not scored")
    assert "calm" not in judged.recordings


def test_every_pair_is_counted_once(tables):
    table = pd.concat(tables, ignore_index=True)
    experience = count_experience(table)
    assert experience.pairs.shape == experience.occluding.shape == (8, 8, 3, 3)
    assert experience.pairs.sum() == len(table)
    assert experience.occluding.sum() == table["occludes"].sum()
    assert (experience.occluding <= experience.pairs).all()
    row = table.iloc[len(table) // 2]
    asked = [int(row[name]) for name in ("direction1", "direction2", "level1", "level2")]
    alike = (table[["direction1", "direction2", "level1", "level2"]] == asked).all(axis=1)
    assert experience.pairs[tuple(np.array(asked) - 1)] == alike.sum()
    assert experience.occluding[tuple(np.array(asked) - 1)] == table.loc[alike, "occludes"].sum()
    pairs, occluding = experience.by_direction()
    assert pairs.shape == (8, 8)
    assert pairs.sum() == len(table)
    assert occluding.sum() == table["occludes"].sum()


def test_experience_is_laid_out_as_the_tables_of_the_thesis(tables):
    table = pd.concat(tables, ignore_index=True)
    experience = count_experience(table)
    cell = np.indices((8, 8, 3, 3)).reshape(4, -1) + 1
    rule = look_up(*cell).reshape(8, 8, 3, 3)
    of_pairs = look_up(*table[["direction1", "direction2", "level1", "level2"]].to_numpy().T)
    for code in (APART, CERTAIN, BY_SPEED):
        assert experience.pairs[rule == code].sum() == (of_pairs == code).sum()
    # The thesis says yes in no cell but those of occlusion.
    yes = count_experience(table.assign(occludes=table["thesis.probability"] == 1))
    assert yes.occluding[rule == APART].sum() == 0
    assert yes.occluding.sum() > 0


def test_experience_by_speed_is_of_those_who_go_one_way():
    table = pd.DataFrame(
        {
            "direction1": [2, 3, 7, 3, 1],
            "direction2": [4, 3, 6, 7, 3],
            "level1": [3, 3, 1, 2, 1],
            "level2": [1, 1, 2, 2, 1],
            "occludes": [True, False, True, True, True],
        }
    )
    experience = count_experience(table)
    pairs, occluding = experience.by_speed("right")
    assert pairs.tolist() == [[0, 0, 0], [0, 0, 0], [2, 0, 0]]
    assert occluding.tolist() == [[0, 0, 0], [0, 0, 0], [1, 0, 0]]
    pairs, occluding = experience.by_speed("left")
    assert pairs.tolist() == [[0, 1, 0], [0, 0, 0], [0, 0, 0]]
    with pytest.raises(ArgumentError, match="side"):
        experience.by_speed("up")


@pytest.mark.parametrize(
    ("column", "value", "match"),
    [
        ("direction1", 0, "table.direction1 must hold whole numbers from 1 to 8"),
        ("direction2", 9, "table.direction2"),
        ("level1", 0, "table.level1 must hold whole numbers from 1 to 3"),
        ("level2", 4, "table.level2"),
        ("level2", 1.5, "table.level2"),
        ("direction1", np.nan, "table.direction1"),
    ],
)
def test_directions_and_levels_that_are_none_are_refused(tables, column, value, match):
    with pytest.raises(ArgumentError, match=match):
        count_experience(tables[0].assign(**{column: value}))


def test_a_table_that_was_not_asked_is_refused(tables):
    with pytest.raises(McnError, match=r"lacks the column.*level2"):
        count_experience(tables[0].drop(columns="level2"))


@pytest.fixture(scope="module")
def real(recordings):
    tables, _ = compare_sequences(recordings / "motchallenge")
    return judge(tables, draws=2)


STATIC = ("mot17-02-frcnn", "mot17-04-frcnn", "pets09-s2l1", "tud-stadtmitte")


@pytest.mark.parametrize("name", STATIC)
def test_the_default_beats_straight_lines_on_every_static_sequence(real, name):
    assert not real.moving[name]
    ours, theirs = (real.scores[name, method] for method in (DEFAULT, "constant-velocity"))
    assert ours.f1.value > theirs.f1.value
    assert ours.ap.value > theirs.ap.value


def test_the_default_beats_the_others_by_far_on_average(real):
    f1 = {
        method: np.mean([real.scores[name, method].f1.value for name in STATIC])
        for method in METHODS
    }
    # 0.05 is the issue's; the printed tables are behind straight lines, too.
    assert f1[DEFAULT] >= f1["constant-velocity"] + 0.05
    assert f1["constant-velocity"] > f1["thesis"]


@pytest.mark.parametrize("name", STATIC[:2])
def test_the_default_knows_when(real, name):
    assert real.scores[name, DEFAULT].time_error_s.value <= 0.35


def test_the_pairs_are_as_many_as_the_issue_counts(real):
    counts = real.table.groupby("recording")["occludes"].agg(["size", "mean"])
    assert counts.loc["mot17-02-frcnn", "size"] == 5780
    assert counts.loc["mot17-04-frcnn", "size"] == 28052
    assert counts["mean"].round(3)[list(STATIC[:2])].tolist() == [0.078, 0.008]
