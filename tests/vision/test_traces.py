"""Traces of walkers whose ways are known, and of the people of PETS 2009."""

from functools import partial

import cv2
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.cameras.homography import project
from mcnlab.datasets.video import open_video
from mcnlab.errors import ArgumentError, SilhouetteError, TableError
from mcnlab.tables import FRAME, TRACE, X, Y, check_traces
from mcnlab.vision import flow
from mcnlab.vision.feet import (
    METHODS,
    PersonSizes,
    background_masks,
    flow_masks,
    learn_height,
    moving_masks,
    trunk_widths,
)
from mcnlab.vision.recordings import trace_pets, true_pets_feet
from mcnlab.vision.traces import link, score_traces, smooth, trace_video

SLOW = settings(max_examples=30)

# A made-up scene: straight ground, 25 pixels a metre across and down, people 40 pixels tall.
WIDTH, HEIGHT, RATE, PIXEL = 320, 160, 10.0, 0.04
TALL, WIDE = 40, 14
TO_GROUND = partial(project, [[PIXEL, 0, 0], [0, -PIXEL, PIXEL * HEIGHT], [0, 0, 1]])
SIZES = PersonSizes(np.full((HEIGHT, WIDTH), float(TALL)), np.full((HEIGHT, WIDTH), 12.0))


SHIRT = cv2.GaussianBlur(np.random.default_rng(1).normal(0, 120, (TALL, WIDE)), (0, 0), 1.2)


def draw(frame, x, y, level=200):
    """A person in grey: trunk and two legs, the feet's middle at (x, y)."""
    left, top = round(x - WIDE / 2), round(y) - TALL + 1
    frame[top : top + 26, left : left + WIDE] = level
    for leg in (left + 1, left + 8):
        frame[top : top + TALL, leg : leg + 5] = level
    return (slice(top, top + TALL), slice(left, left + WIDE))


def film(*ways, n=60, still=25, noise=2.0):
    """A video of walkers in patterned clothes on a textured ground, empty at the end."""
    rng = np.random.default_rng(0)
    ground = cv2.GaussianBlur(rng.normal(90, 60, (HEIGHT, WIDTH)), (0, 0), 1.5)
    frames = []
    for number in range(n + still):
        frame = ground.copy()
        # The nearer one covers the farther.
        for way in sorted(ways, key=lambda way: way(number)[1]) if number < n else ():
            bare = frame.copy()
            box = draw(frame, *way(number))
            frame[box] += np.where(frame[box] != bare[box], SHIRT, 0.0)
        frames.append(np.clip(frame + rng.normal(0, noise, frame.shape), 0, 255))
    return open_video(np.array(frames, np.uint8), frame_rate=RATE)


def walk(x, y, vx, vy=0.0):
    return lambda number: (x + vx * number, y + vy * number)


def truth_of(*ways, n=60):
    frame = np.arange(n)
    return pd.concat(
        [
            pd.DataFrame(
                {
                    TRACE: f"walker {number}",
                    FRAME: frame,
                    X: (way(frame)[0]) * PIXEL,
                    # The ground is that of the pixel row below the feet.
                    Y: (HEIGHT - way(frame)[1] - 1 + 0.0 * frame) * PIXEL,
                }
            )
            for number, way in enumerate(ways)
        ],
        ignore_index=True,
    )


RIGHT, LEFT = walk(30, 80, 4.0), walk(280, 140, -3.5)


@pytest.fixture(scope="module")
def two_walkers():
    return film(RIGHT, LEFT)


@pytest.mark.parametrize("method", ["background", "horn-schunck-plain"])
def test_two_walkers_leave_two_traces_where_they_walked(two_walkers, method):
    traces = trace_video(two_walkers, TO_GROUND, method=method, height=TALL)
    assert check_traces(traces)[TRACE].nunique() == 2
    score = score_traces(traces, truth_of(RIGHT, LEFT), radius=0.5)
    # A background's outline is good to a pixel, and a box is laid to two: 0.08 m.  Flow is
    # spread by a pixel in each of five iterations, and by the blur and the slopes' reach, two
    # more: 0.28 m.
    bound = 0.08 if method == "background" else 0.28
    assert score.median_error < bound
    # A trace starts when one is in view and moves; a second of 6 may be lost at either end.
    assert score.recall > 0.8
    assert score.precision > 0.9


@pytest.mark.parametrize("method", METHODS)
def test_every_method_finds_the_walkers(two_walkers, method):
    traces = trace_video(two_walkers, TO_GROUND, method=method, height=TALL)
    # Within the 15 pixels by which Farnebäck's window spreads.
    assert score_traces(traces, truth_of(RIGHT, LEFT), radius=0.6).recall > 0.8


def test_flow_masks_are_those_of_1981_with_few_iterations(two_walkers):
    plain, sharp = (
        list(flow_masks(two_walkers, **options))
        for options in (
            {},
            {"method": "horn-schunck-plain", "alpha": 25.0, "iterations": 5},
        )
    )
    assert np.array_equal(plain, sharp)
    # The others have the defaults of `flow`: the pyramid's name gives the pyramid.
    frames = list(two_walkers.frames(0, 2))
    first = next(flow_masks(two_walkers, method="horn-schunck", speed=0.5, closing=0))
    assert np.array_equal(first, flow.moving_mask(flow.horn_schunck(*frames), speed=0.5))


def test_options_reach_the_masks(two_walkers):
    with pytest.raises(SilhouetteError, match="nobody moved"):
        trace_video(
            two_walkers,
            TO_GROUND,
            method="horn-schunck-plain",
            height=TALL,
            mask_options={"speed": 50.0},
        )


def test_walkers_who_cross_both_live_on():
    # They pass each other in the middle, one hides the other for half a second.
    ways = walk(40, 90, 4.0), walk(280, 96, -4.0)
    traces = trace_video(film(*ways), TO_GROUND, height=TALL)
    assert traces[TRACE].nunique() == 2
    ends = traces.groupby(TRACE)[X].agg(["first", "last"])
    # Each ends at the side where the other began.
    assert (np.diff(ends.to_numpy(), axis=1).ravel() > 0).tolist().count(True) == 1
    assert (np.abs(ends["last"] - ends["first"]) > 200 * PIXEL).all()
    assert score_traces(traces, truth_of(*ways), radius=0.5).recall > 0.9


def test_how_tall_people_appear_is_learnt_from_them(two_walkers):
    widths = trunk_widths((HEIGHT, WIDTH), TO_GROUND)
    height = learn_height(background_masks(two_walkers), widths)
    # All are 40 pixels tall; opening and closing may shave or add a row at either end.
    assert height([[100, 80], [100, 140]]) == pytest.approx(TALL, abs=2)
    learnt = trace_video(two_walkers, TO_GROUND)
    assert score_traces(learnt, truth_of(RIGHT, LEFT), radius=0.5).median_error < 0.08


def test_masks_of_booleans_teach_the_same_height(two_walkers):
    widths = trunk_widths((HEIGHT, WIDTH), TO_GROUND)
    masks = list(background_masks(two_walkers))
    points = [[100, 80], [100, 140]]
    taught = learn_height((mask > 0 for mask in masks), widths)(points)
    assert taught.tolist() == learn_height(masks, widths)(points).tolist()


@pytest.mark.parametrize(
    ("mask", "words"),
    [
        (np.zeros((5, 5), np.uint8), "mask has the shape .* shape of widths"),
        (np.zeros((HEIGHT, WIDTH, 3), np.uint8), "mask has the shape"),
        (np.full((HEIGHT, WIDTH), np.nan), "finite"),
        (np.full((HEIGHT, WIDTH), "a"), "finite numbers"),
    ],
    ids=["shape", "colour", "nan", "text"],
)
def test_a_mask_that_is_none_teaches_nothing(mask, words):
    with pytest.raises(ArgumentError, match=words):
        learn_height([mask], trunk_widths((HEIGHT, WIDTH), TO_GROUND))


def test_a_run_can_be_repeated_to_the_bit(two_walkers):
    for method in ("background", "horn-schunck-plain"):
        first, again = (
            trace_video(two_walkers, TO_GROUND, method=method, height=TALL) for _ in range(2)
        )
        pd.testing.assert_frame_equal(first, again, check_exact=True)


@pytest.mark.parametrize("method", ["background", "horn-schunck-plain"])
def test_where_nobody_moves_that_is_said(method):
    video = open_video(np.full((30, HEIGHT, WIDTH), 90, np.uint8), frame_rate=RATE)
    assert not any(mask.any() for mask in moving_masks(video, method=method))
    with pytest.raises(SilhouetteError, match="nobody moved in 30 frames"):
        trace_video(video, TO_GROUND, method=method, height=TALL)
    with pytest.raises(SilhouetteError, match="0 silhouettes"):
        trace_video(video, TO_GROUND, method=method)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda video: moving_masks(video, method="magic"), "method"),
        (lambda video: flow_masks(video, method="background"), "method"),
        (lambda video: flow_masks(video, speed=0), "speed"),
        (lambda video: flow_masks(video, closing=-1), "closing"),
        (lambda video: background_masks(video, shadow=0), "shadow"),
        (lambda video: list(flow_masks(video, alpha=0)), "alpha"),
        (lambda video: background_masks(video, threshold=np.nan), "threshold"),
        (lambda video: background_masks(video, learning_rate=2), "learning_rate"),
        (lambda video: background_masks(video, warm_up=0), "warm_up"),
        (lambda video: trace_video(video, TO_GROUND, height=0), "height"),
        (lambda video: trace_video(video, TO_GROUND, height=np.inf), "height"),
        (lambda video: trace_video(video, TO_GROUND, height=2.0), "less than 8 pixels"),
        (lambda video: trace_video(video, TO_GROUND, height=TALL, coarsest=0.01), "coarsest"),
        (lambda video: trace_video(video, TO_GROUND, height=TALL, gate=-1), "gate"),
        (lambda video: trace_video(video, TO_GROUND, height=TALL, most_gap=1e6), "most_gap"),
        (lambda video: flow_masks(video, method="dis", bogus=1), "'dis' has no option 'bogus'"),
        (lambda video: moving_masks(video, bogus=1), "'background' has no option 'bogus'"),
        (
            lambda video: moving_masks(video, method="dis", alpha=1),
            "'alpha'; pass any of speed.* preset",
        ),
        (lambda video: trace_video(video, TO_GROUND, mask_options=["speed"]), "mask_options"),
        (lambda video: trace_video(video, TO_GROUND, mask_options={1: 2}), "no option 1"),
        (lambda video: trace_video(video, TO_GROUND, mask_options={"method": 2}), "no option 'm"),
        (
            lambda video: trace_video(video, TO_GROUND, mask_options={"bogus": 1}),
            "no option 'bogus'; pass any of threshold, shadow, learning_rate, warm_up",
        ),
        (lambda video: trace_video("film.mp4", TO_GROUND), "video is a str"),
        (lambda video: trace_video(video, None, height=TALL), "to_ground"),
        (lambda video: trace_video(video, lambda points: points[:, 0]), "to_ground"),
    ],
)
def test_an_impossible_option_is_refused(two_walkers, call, words):
    with pytest.raises(ArgumentError, match=words):
        call(two_walkers)


def feet_of(*walkers, drop=()):
    """Detections of walkers, each (start, velocity), at steps of one frame."""
    frame = np.arange(40)
    rows = [
        pd.DataFrame({FRAME: frame, X: x + vx * frame, Y: y + vy * frame})
        for x, y, vx, vy in walkers
    ]
    return pd.concat([part[~part[FRAME].isin(drop)] for part in rows], ignore_index=True)


def traces_in(feet, **options):
    return link(feet, frame_rate=RATE, **options)[TRACE].nunique()


speeds = st.floats(-0.2, 0.2)  # metres a frame: up to 2 m/s


@st.composite
def separated(draw):
    """Two to four walkers who keep 5 m apart at least."""
    n = draw(st.integers(2, 4))
    vx, vy = draw(speeds), draw(speeds)
    # One common velocity, and each its own within 0.02 m a frame: 0.8 m apart over 40 frames.
    own = draw(arrays(float, (n, 2), elements=st.floats(-0.02, 0.02)))
    return [(6.0 * k, 0.0, vx + dx, vy + dy) for k, (dx, dy) in enumerate(own)]


@given(separated(), st.randoms(use_true_random=False))
@SLOW
def test_the_order_of_rows_does_not_matter(walkers, random):
    feet = feet_of(*walkers)
    order = list(range(len(feet)))
    random.shuffle(order)
    straight, shuffled = (link(part, frame_rate=RATE) for part in (feet, feet.iloc[order]))
    pd.testing.assert_frame_equal(straight, shuffled)


@given(separated(), st.sets(st.integers(5, 30), max_size=8))
@SLOW
def test_walkers_far_apart_are_told_apart_through_gaps(walkers, missing):
    traces = link(feet_of(*walkers, drop=missing), frame_rate=RATE)
    assert traces[TRACE].nunique() == len(walkers)
    # A steady walk is what the smoother takes for smoothest: no error but rounding.
    whole = feet_of(*walkers).sort_values([FRAME, X]).reset_index(drop=True)
    found = traces.sort_values([FRAME, X]).reset_index(drop=True)
    assert found[[X, Y]].to_numpy() == pytest.approx(whole[[X, Y]].to_numpy(), abs=1e-4)


@given(separated(), st.integers(0, 2**32 - 1))
@SLOW
def test_time_reversal_gives_the_same_links(walkers, seed):
    feet = feet_of(*walkers)
    feet[[X, Y]] += np.random.default_rng(seed).normal(0, 0.05, (len(feet), 2))
    forward = link(feet, frame_rate=RATE)
    backward = link(feet.assign(**{FRAME: 39 - feet[FRAME]}), frame_rate=RATE)
    backward = backward.assign(**{FRAME: 39 - backward[FRAME]})
    order = [FRAME, X]
    forward, backward = (part.sort_values(order)[[X, Y]] for part in (forward, backward))
    assert forward.to_numpy() == pytest.approx(backward.to_numpy(), abs=1e-6)


@given(
    arrays(float, st.tuples(st.integers(30, 90), st.just(2)), elements=st.floats(-4, 4)),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=50)
def test_whatever_the_feet_no_trace_has_two_in_a_frame(places, seed):
    frame = np.random.default_rng(seed).integers(0, 30, len(places))
    feet = pd.DataFrame({FRAME: frame, X: places[:, 0], Y: places[:, 1]})
    try:
        traces = link(feet, frame_rate=RATE, shortest=0.3)
    except TableError as refusal:
        assert "no trace" in str(refusal)
        return
    check_traces(traces)
    # Traces are continuous, and not more of them in a frame than can be: one foot makes one.
    assert (traces.groupby(TRACE)[FRAME].diff().dropna() == 1).all()
    assert len(traces[TRACE].unique()) <= len(feet)


def test_a_jump_beyond_the_gate_makes_another_trace():
    feet = feet_of((0, 0, 0.1, 0))
    feet.loc[feet[FRAME] >= 20, Y] += 3.0
    assert traces_in(feet, gate=1.5) == 2
    assert traces_in(feet, gate=4.0) == 1


def test_a_gap_is_bridged_up_to_its_length():
    feet = feet_of((0, 0, 0.1, 0.05), drop=range(14, 26))  # twelve frames, 1.2 s
    assert traces_in(feet, most_gap=1.1) == 2
    bridged = link(feet, frame_rate=RATE, most_gap=1.2)
    assert bridged[FRAME].tolist() == list(range(40))
    assert bridged[X].to_numpy() == pytest.approx(0.1 * np.arange(40), abs=1e-4)


def test_short_traces_are_dropped():
    feet = feet_of((0, 0, 0.1, 0))
    stray = pd.DataFrame({FRAME: range(5), X: 20.0, Y: 0.0})
    both = pd.concat([feet, stray])
    assert traces_in(both, shortest=1.0) == 1
    assert traces_in(both, shortest=0.5) == 2
    with pytest.raises(TableError, match="no trace of 5 s"):
        link(both, frame_rate=RATE, shortest=5)


@pytest.mark.parametrize(
    ("feet", "words"),
    [
        (None, "DataFrame"),
        (feet_of((0, 0, 0, 0)).iloc[:0], "no rows"),
        (feet_of((0, 0, 0, 0)).drop(columns=X), "lacks"),
        (feet_of((np.nan, 0, 0, 0)), "finite numbers"),
        (feet_of((np.inf, 0, 0, 0)), "finite numbers"),
        (feet_of((0, 0, 0, 0)).assign(frame=0.5), "whole numbers"),
        (feet_of((0, 0, 0, 0)).assign(x="a"), "no number"),
    ],
    ids=["none", "empty", "column", "nan", "inf", "fraction", "text"],
)
def test_feet_that_are_none_are_refused(feet, words):
    with pytest.raises(TableError, match=words):
        link(feet, frame_rate=RATE)


def test_one_stray_place_hardly_moves_a_walk():
    frame = np.arange(30.0)
    places = np.stack([0.1 * frame, 0 * frame], axis=1)
    places[::2, 1] += 0.02  # a spread to judge the stray by
    clean = smooth(places, weights=np.ones(30), stiffness=100.0)
    places[15, 1] += 2.0
    moved = smooth(places, weights=np.ones(30), stiffness=100.0)
    # Limited to twice the spread of some 0.015 m in place of 2 m.
    assert np.abs(moved - clean).max() < 0.05


def test_a_stiff_smoother_gives_the_straight_line_and_a_limp_one_the_places():
    rng = np.random.default_rng(0)
    frame = np.arange(20.0)
    places = np.stack([frame, -frame], axis=1) + rng.normal(0, 0.1, (20, 2))
    limp = smooth(places, weights=np.ones(20), stiffness=0.0)
    assert limp == pytest.approx(places)
    stiff = smooth(places, weights=np.ones(20), stiffness=1e9, huber=1e9)
    lines = np.polynomial.Polynomial
    for axis in (0, 1):
        line = lines.fit(frame, places[:, axis], 1)(frame)
        assert stiff[:, axis] == pytest.approx(line, abs=1e-4)


def test_a_smoother_needs_two_places():
    with pytest.raises(ArgumentError, match="at least two places"):
        smooth(np.zeros((5, 2)), weights=[0, 0, 1, 0, 0], stiffness=1)
    with pytest.raises(ArgumentError, match="finite"):
        smooth(np.full((5, 2), np.nan), weights=np.ones(5), stiffness=1)
    with pytest.raises(ArgumentError, match="weights has the shape"):
        smooth(np.zeros((5, 2)), weights=np.ones(4), stiffness=1)


def table(*rows):
    return pd.DataFrame(rows, columns=[TRACE, FRAME, X, Y]).sort_values([TRACE, FRAME])


def test_a_score_worked_out_by_hand():
    truth = table(("a", 0, 0, 0), ("a", 1, 0, 0), ("b", 0, 5, 0), ("b", 1, 5, 0))
    traces = table(
        ("1", 0, 0.3, 0.4),  # half a metre from a
        ("1", 1, 3.0, 0.0),  # nobody's
        ("2", 0, 0.1, 0.0),  # nearer to a, but then the one above would have nobody …
        ("3", 1, 5.0, 0.2),
        ("4", 7, 5.0, 0.0),  # after the truth's last frame: not judged
    )
    score = score_traces(traces, truth)
    assert (score.recall, score.precision) == (2 / 4, 2 / 4)
    # … as pairs are one to one, and the nearer pair wins.
    assert score.feet["found"].tolist() == [True, False, False, True]
    assert score.feet["error"].tolist() == pytest.approx([0.1, 1.0, 1.0, 0.2])
    assert score.points["matched"].tolist() == [False, False, True, True]
    assert score.median_error == pytest.approx(0.15)
    first = score.between(0, 1)
    assert (first.recall, first.precision) == (1 / 2, 1 / 2)


def test_as_many_pairs_as_possible_are_made():
    # Greedily 1 would take a, and leave 2 without anyone: the pairs (1, b), (2, a) both hold.
    truth = table(("a", 0, 0, 0), ("b", 0, 1.5, 0))
    traces = table(("1", 0, 0.6, 0), ("2", 0, -0.9, 0))
    score = score_traces(traces, truth)
    assert (score.recall, score.precision) == (1, 1)
    assert score.median_error == pytest.approx(0.9)


def test_the_truth_scores_itself_without_error():
    truth = truth_of(RIGHT, LEFT)
    score = score_traces(truth, truth)
    assert (score.recall, score.precision, score.median_error) == (1, 1, 0)


def test_traces_at_another_place_or_time_score_nothing_and_no_nan():
    truth = table(("a", 0, 0, 0), ("a", 1, 0, 0))
    for elsewhere in (table(("1", 0, 9, 0)), table(("1", 5, 0, 0))):
        score = score_traces(elsewhere, truth)
        assert (score.recall, score.precision, score.median_error) == (0, 0, 1)
        assert np.isfinite(score.feet["error"]).all()
    with pytest.raises(ArgumentError, match="no true feet"):
        score.between(5, 9)
    with pytest.raises(ArgumentError, match="radius"):
        score_traces(truth, truth, radius=0)
    with pytest.raises(TableError, match="truth"):
        score_traces(truth, truth.iloc[:0])


def test_people_of_pets_are_traced_on_the_half_that_nothing_was_tuned_on(recordings):
    found = trace_pets(recordings, "background")
    score = score_traces(found, true_pets_feet(recordings))
    assert len(score.feet) == 4650
    for part in (score, score.between(397, 795)):
        assert part.recall >= 0.75
        assert part.precision >= 0.80
        assert part.median_error <= 0.35
