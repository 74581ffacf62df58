"""Pairs of walkers and their truth, against the definition followed box by box."""

from collections import Counter
from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab.cameras import horizon
from mcnlab.datasets.mirror import add_mirrored, mirror_boxes
from mcnlab.datasets.motchallenge import read_sequence
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError, TableError
from mcnlab.occlusion import pairs as module
from mcnlab.occlusion.composites import compose
from mcnlab.occlusion.pairs import RULES, Rules, find_pairs, lay_over, watch
from mcnlab.synthetic import crossings
from mcnlab.synthetic.crossings import Square, make_crossings
from mcnlab.tables import BOX_COLUMNS

WIDTH, HEIGHT = 200, 150
seeds = st.integers(0, 10**6)
rates = st.sampled_from([2, 7, 10, 29.97])


def record(tracks, *, rate=10, width=WIDTH, height=HEIGHT, subjects=None):
    """A recording of tracks: name → (frames, x, y, w, h), each an array or a number."""
    tables = []
    for name, (frames, x, y, w, h) in tracks.items():
        held = {"sequence": name, "subject": (subjects or {}).get(name, name), "frame": frames}
        held |= {"x": x, "y": y, "w": w, "h": h}
        table = pd.DataFrame(held)
        tables.append(table.assign(cx=table["x"] + table["w"] / 2, cy=table["y"] + table["h"] / 2))
    table = pd.concat(tables, ignore_index=True)[list(BOX_COLUMNS)]
    return Recording("made-up", table, rate, width, height)


def scatter(seed, rate, *, walkers=4, seconds=8.0, gaps=0.12):
    """People on straight lines through a small frame, with gaps, at times of their own."""
    rng = np.random.default_rng(seed)
    tracks = {}
    for number in range(walkers):
        frames = rng.integers(0, int(2 * rate)) + np.arange(int(seconds * rate))
        t = (frames - frames.mean()) / rate
        w, h = rng.uniform(10, 20), rng.uniform(30, 60)
        grow = np.exp(rng.uniform(-0.05, 0.05) * t)
        x = rng.uniform(60, 140) + rng.uniform(-12, 12) * t
        y = rng.uniform(20, 60) + rng.uniform(-4, 4) * t
        keep = rng.uniform(size=len(frames)) >= gaps * rng.uniform()
        keep[0] = True
        tracks[f"w{number}"] = tuple(a[keep] for a in (frames, x, y, w * grow, h * grow))
    return record(tracks, rate=rate)


def share(first, second):
    """Cover of two boxes, and the middle of their intersection, one number at a time."""
    (x, y, w, h), (u, v, a, b) = first, second
    left, right, top, bottom = max(x, u), min(x + w, u + a), max(y, v), min(y + h, v + b)
    cover = max(right - left, 0) * max(bottom - top, 0) / min(w * h, a * b)
    # Half a pixel from the edges: pixels count from the centre of the first.
    return cover, (left + right - 1) / 2, (top + bottom - 1) / 2


def follow_definition(recording):
    """(frame, first, second) → (occludes, seconds, x, y), by the issue's words."""
    box = {
        (row.sequence, row.frame): (row.x, row.y, row.w, row.h)
        for row in recording.boxes.itertuples()
    }
    fps = round(recording.frame_rate)
    horizon = round(3 * recording.frame_rate)
    frames = recording.boxes["frame"]
    found = {}
    for t in range(frames.min() + fps - 1, frames.max() + 1, fps):
        for one, two in combinations(recording.sequences, 2):
            needed = [(who, at) for who in (one, two) for at in (t, t - fps // 2, t - fps + 1)]
            if not all(key in box for key in needed):
                continue
            second = range(t - fps + 1, t + 1)
            if min(sum((who, at) in box for at in second) for who in (one, two)) < 0.8 * fps:
                continue
            later = [at for at in range(t + 1, t + horizon + 1)]
            both = [at for at in later if (one, at) in box and (two, at) in box]
            if len(both) < 0.6 * horizon or share(box[one, t], box[two, t])[0] > 0.05:
                continue
            truth = (False, 0.0, 0.0, 0.0)
            for at in both:
                cover, x, y = share(box[one, at], box[two, at])
                if cover > 0.3:
                    truth = (True, (at - t) / recording.frame_rate, x, y)
                    break
            found[t, one, two] = truth
    return found


def found_in(pairs, names):
    """The same of `find_pairs`."""
    names = np.array(names)[pairs.track]
    keys = zip(pairs.frame.tolist(), *names.T.tolist(), strict=True)
    truth = zip(pairs.occludes.tolist(), pairs.seconds, pairs.x, pairs.y, strict=True)
    found = dict(zip(keys, truth, strict=True))
    assert len(found) == len(pairs)
    return found


def assert_same(found, wanted, *, abs_=1e-9):
    assert found.keys() == wanted.keys()
    for key, truth in wanted.items():
        assert found[key] == pytest.approx(truth, abs=abs_), key


def find_or_none(recording, **options):
    try:
        return found_in(find_pairs(recording, **options), recording.sequences)
    except DatasetError:
        return {}


@given(seed=seeds, rate=rates)
@settings(max_examples=60)
def test_pairs_and_their_truth_are_those_of_the_definition(seed, rate):
    recording = scatter(seed, rate)
    assert_same(find_or_none(recording), follow_definition(recording))


def test_the_definition_is_tried_on_both_answers_and_on_gaps():
    kinds = Counter()
    for seed in range(20):
        recording = scatter(seed, 10)
        lengths = recording.stack.length.sum()
        kinds["gaps"] += lengths - len(recording.boxes)
        kinds.update(truth[0] for truth in follow_definition(recording).values())
    assert min(kinds[True], kinds[False], kinds["gaps"]) >= 40


@pytest.mark.parametrize(
    ("name", "count", "occlusions", "share_"),
    [("MOT17-02-FRCNN", 5780, 453, 0.078), ("MOT17-04-FRCNN", 28052, 230, 0.008)],
)
def test_motchallenge_yields_the_stated_pairs(recordings, name, count, occlusions, share_):
    pairs = find_pairs(read_sequence(recordings / "motchallenge" / name))
    assert (len(pairs), pairs.occludes.sum()) == (count, occlusions)
    assert round(pairs.occludes.mean(), 3) == share_


def side_by_side(frames, *, rate=10, drop=(), first=1):
    """Two who stand apart for some frames; the second without boxes in frames `drop`."""
    every = first + np.arange(frames)
    kept = every[~np.isin(every, drop)]
    return record({"a": (every, 10, 20, 10, 40), "b": (kept, 100, 20, 10, 40)}, rate=rate)


# At 10 frames a second the first moment is frame 10, and 18 of the next 30 frames are needed.
@pytest.mark.parametrize(("frames", "moments"), [(28, 1), (37, 1), (38, 2), (40, 2), (100, 8)])
def test_moments_are_whole_seconds_that_are_followed(frames, moments):
    pairs = find_pairs(side_by_side(frames))
    assert pairs.frame.tolist() == [10 * (1 + number) for number in range(moments)]


@pytest.mark.parametrize("frames", [1, 9, 10, 20, 27])
def test_too_short_a_recording_has_no_pair(frames):
    with pytest.raises(DatasetError, match=r"made-up holds no pair .* longer"):
        find_pairs(side_by_side(frames))


def test_exactly_two_seconds_suffice_for_a_horizon_of_one():
    assert find_pairs(side_by_side(20), rules=Rules(horizon=1)).frame.tolist() == [10]


# The last second before frame 20 is 11 … 20; the middle one of it is 15.
@pytest.mark.parametrize(
    ("drop", "holds"),
    [
        ((12, 13), True),
        ((12, 13, 14), False),
        ((11,), False),
        ((15,), False),
        ((20,), False),
        (range(21, 33), True),
        (range(21, 34), False),
    ],
)
def test_boxes_may_be_missing_but_not_too_many_nor_at_the_ends(drop, holds):
    found = find_or_none(side_by_side(60, drop=drop))
    assert ((20, "a", "b") in found) == holds


def test_a_cover_at_the_bound_is_still_apart_and_no_occlusion():
    # Boxes of 10 × 40: a shared strip of 10 × 2 is 0.05, one of 10 × 12 is 0.3.
    every = np.arange(1, 61)
    for deep, pair in ((2, True), (2.01, False)):
        recording = record({"a": (every, 10, 0, 10, 40), "b": (every, 10, 40 - deep, 10, 40)})
        assert bool(find_or_none(recording)) == pair
    for deep, occludes in ((12, False), (12.01, True)):
        y = np.where(every > 25, 40 - deep, 90)
        found = find_or_none(record({"a": (every, 10, 0, 10, 40), "b": (every, 10, y, 10, 40)}))
        assert found[10, "a", "b"][0] == found[20, "a", "b"][0] == occludes
    assert found[20, "a", "b"] == pytest.approx((True, 0.6, 14.5, 39.5 - 12.01 / 2))
    assert found[10, "a", "b"][1] == pytest.approx(1.6)


def test_an_occlusion_counts_up_to_the_horizon_and_no_longer():
    every = np.arange(1, 101)
    for begin, occludes in ((40, True), (41, False)):
        x = np.where(every >= begin, 12, 100)
        found = find_or_none(record({"a": (every, 10, 0, 10, 40), "b": (every, x, 0, 10, 40)}))
        assert found[10, "a", "b"][0] == occludes
    assert found[20, "a", "b"][:2] == (True, 2.1)


def test_who_appears_or_leaves_is_paired_while_he_is_there():
    every = np.arange(1, 101)
    late, early = every[every >= 35], every[every <= 62]
    tracks = {"a": (every, 10, 0, 10, 40), "b": (late, 50, 0, 10, 40), "c": (early, 90, 0, 10, 40)}
    found = find_or_none(record(tracks))
    # b is seen for a second from 44 on; c for 18 frames more until 44.
    assert {t for t, *who in found if who == ["a", "b"]} == {50, 60, 70, 80}
    assert {t for t, *who in found if who == ["a", "c"]} == {10, 20, 30, 40}
    assert not {t for t, *who in found if who == ["b", "c"]}


@pytest.mark.parametrize("first", [0, 1, 1000])
@pytest.mark.parametrize("rate", [2, 7, 10, 29.97])
def test_frames_count_from_the_recordings_first(first, rate):
    second = round(rate)
    pairs = find_pairs(side_by_side(4 * second, rate=rate, first=first))
    assert pairs.frame.tolist() == [first + second - 1, first + 2 * second - 1]
    assert pairs.walkers.time[-1] == 0
    assert len(pairs.walkers.time) == second
    np.testing.assert_allclose(np.diff(pairs.walkers.time), 1 / rate)


def test_seconds_are_frames_by_the_true_rate():
    every = np.arange(1, 91)
    x = np.where(every >= 45, 12, 100)
    recording = record({"a": (every, 10, 0, 10, 40), "b": (every, x, 0, 10, 40)}, rate=29.97)
    assert find_pairs(recording).seconds.tolist() == [15 / 29.97]


def test_a_track_years_later_changes_nothing():
    recording = scatter(1, 10)
    later = recording.boxes[recording.boxes["sequence"] == "w0"].assign(sequence="z", subject="z")
    later["frame"] += 900_000_000
    both = recording.with_boxes(pd.concat([recording.boxes, later], ignore_index=True))
    assert find_or_none(both) == find_or_none(recording)


@pytest.mark.parametrize("kind", ["uint8", "int32", "float64", "Int64"])
def test_frame_numbers_may_be_of_any_type(kind):
    recording = scatter(1, 10)
    changed = recording.with_boxes(recording.boxes.astype({"frame": kind}))
    assert find_or_none(changed) == find_or_none(recording)
    assert find_pairs(changed).frame.dtype == np.int64


def test_it_does_not_matter_how_many_are_judged_at_once(monkeypatch):
    recording = scatter(2, 10)
    whole = find_or_none(recording)
    monkeypatch.setattr(module, "CHUNK", 3)
    assert find_or_none(recording) == whole


def test_nothing_is_of_a_loose_type_or_not_finite():
    pairs = find_pairs(scatter(3, 7))
    walkers = pairs.walkers
    for value in (pairs.who, pairs.track, pairs.now, pairs.frame):
        assert value.dtype == np.int64
    assert pairs.occludes.dtype == walkers.seen.dtype == bool
    assert pairs.people.dtype.kind == "U"
    for value in (pairs.seconds, pairs.x, pairs.y, pairs.body, walkers.horizon, walkers.rise):
        assert value.dtype == float
        assert np.isfinite(value).all()
    for value in (walkers.x, walkers.feet, walkers.w, walkers.h):
        assert value.shape == walkers.seen.shape == (len(walkers), len(walkers.time))
        assert np.isfinite(value).all()


# What is seen


def test_walkers_hold_the_boxes_up_to_the_moment_and_nothing_else():
    recording = scatter(4, 10)
    pairs = find_pairs(recording)
    walkers, names = pairs.walkers, np.array(recording.sequences)
    rows = recording.boxes.set_index(["sequence", "frame"])
    for pair in range(len(pairs)):
        for one in (0, 1):
            who, name = pairs.who[pair, one], names[pairs.track[pair, one]]
            for column, frame in enumerate(range(pairs.frame[pair] - 9, pairs.frame[pair] + 1)):
                assert walkers.seen[who, column] == ((name, frame) in rows.index)
                if walkers.seen[who, column]:
                    box = rows.loc[(name, frame)]
                    held = [value[who, column] for value in (walkers.x, walkers.feet)]
                    assert held == [box.x + (box.w - 1) / 2, box.y + box.h - 0.5]
                    assert [walkers.w[who, column], walkers.h[who, column]] == [box.w, box.h]


def test_each_walker_is_held_once_a_moment():
    pairs = find_pairs(scatter(4, 10))
    moments = {(track, now) for track, now in zip(pairs.track.flat, pairs.now.flat, strict=True)}
    assert len(moments) == len(pairs.walkers)
    assert sorted(set(pairs.who.flat)) == list(range(len(pairs.walkers)))


def test_a_body_is_the_mean_of_the_two_heights_now():
    every = np.arange(1, 61)
    tracks = {"a": (every, 0, 0, 10, 40.0 + every), "b": (every, 99, 0, 10, 80)}
    assert find_pairs(record(tracks)).body.tolist() == [65, 70, 75, 80]


def seen_by_moment(recording, pairs):
    """(name, frame) → what is seen of that walker."""
    names = np.array(recording.sequences)
    walkers = pairs.walkers
    values = (walkers.x, walkers.feet, walkers.w, walkers.h, walkers.horizon, walkers.rise)
    return {
        (names[track], frame): [value[who].tolist() for value in values]
        for tracks, whos, frame in zip(pairs.track, pairs.who, pairs.frame.tolist(), strict=True)
        for track, who in zip(tracks, whos, strict=True)
    }


@pytest.mark.parametrize("limit", [horizon.HORIZON_BOXES, 100])
def test_the_future_does_not_leak_into_what_is_seen(monkeypatch, limit):
    monkeypatch.setattr(horizon, "HORIZON_BOXES", limit)
    recording = make_crossings(people=12, seconds=16, seed=1)
    until = 200
    later = recording.boxes["frame"] > until
    changed = recording.boxes.copy()
    changed.loc[later, ["x", "y", "h"]] *= [0.7, 0.4, 1.7]
    stranger = changed[changed["sequence"] == changed["sequence"].iloc[0]]
    stranger = stranger.assign(
        sequence="z", subject="z", frame=until + 1 + np.arange(len(stranger))
    )
    other = recording.with_boxes(pd.concat([changed, stranger], ignore_index=True))
    before, after = (seen_by_moment(r, find_pairs(r)) for r in (recording, other))
    same = [key for key in before if key in after and key[1] <= until]
    assert len(same) > 20
    assert all(before[key] == after[key] for key in same)
    assert any(before[key][-1] > 0 for key in same)  # a horizon was found
    assert any(before[key] != after[key] for key in before if key in after and key[1] > until)


def test_the_horizon_is_found_where_it_is(monkeypatch):
    # People of one stature who neither bob nor are boxed wrongly, before a level camera.
    monkeypatch.setattr(crossings, "STATURE", (1.72, 0.0))
    monkeypatch.setattr(crossings, "BOB", 0.0)
    made = make_crossings(square=Square(tilt=0, height=1.5), box_noise=0, people=20, seconds=20)
    walkers = find_pairs(made).walkers
    known = walkers.rise > 0
    assert known.mean() > 0.9
    # The robust fit stops when nothing moves by 1e-3 of its own limit; the line is exact.
    # Its boxes end at the feet, not half a pixel beyond.
    np.testing.assert_allclose(walkers.horizon[known], 239.5 - 0.5, atol=1e-6)
    np.testing.assert_allclose(walkers.rise[known], 1.5 / 1.72, atol=1e-6)


def test_people_of_one_size_show_no_horizon():
    walkers = find_pairs(side_by_side(60)).walkers
    assert not walkers.rise.any()
    assert not walkers.horizon.any()


def test_a_line_that_is_level_but_for_rounding_is_no_horizon():
    # Heights that do not depend on the row: the slope is 0 or what rounding leaves of it.
    every = np.arange(1, 61)
    tall = np.where(every % 4 < 2, 30.1, 60.3)
    feet = 90 + 7.7 * (every % 2)
    for sign in (1, -1):
        tracks = {
            "a": (every, 10, sign * feet - tall, 10, tall),
            "b": (every, 100, sign * feet - tall, 10, tall),
        }
        walkers = find_pairs(record(tracks)).walkers
        assert (np.abs(walkers.horizon) < 1e6).all()


# Properties


@given(seed=seeds, rate=rates)
@settings(max_examples=20)
def test_a_mirrored_recording_has_mirrored_pairs(seed, rate):
    recording = scatter(seed, rate)
    mirrored = recording.with_boxes(mirror_boxes(recording.boxes, frame_width=WIDTH))
    wanted = {
        key: (yes, when, (WIDTH - 1 - x) * yes, y)
        for key, (yes, when, x, y) in find_or_none(recording).items()
    }
    assert_same(find_or_none(mirrored), wanted)


@given(seed=seeds, factor=st.sampled_from([0.25, 2.0, 8.0]))
@settings(max_examples=20)
def test_a_larger_image_changes_places_only(seed, factor):
    # By powers of two, so that no cover is rounded to the other side of a bound.
    recording = scatter(seed, 7)
    scaled = recording.boxes.copy()
    scaled[["x", "y", "w", "h", "cx", "cy"]] *= factor
    wanted = {
        key: (yes, when, (factor * (x + 0.5) - 0.5) * yes, (factor * (y + 0.5) - 0.5) * yes)
        for key, (yes, when, x, y) in find_or_none(recording).items()
    }
    assert_same(find_or_none(recording.with_boxes(scaled)), wanted, abs_=0)


@given(seed=seeds, turn=st.permutations(range(4)))
@settings(max_examples=20)
def test_the_order_of_tracks_and_their_names_do_not_matter(seed, turn):
    recording = scatter(seed, 7)
    walks = [recording.sequence(f"w{number}") for number in turn]
    renamed = [
        walk.assign(sequence=walk["sequence"] + "x", subject="q" * k)
        for k, walk in enumerate(walks, start=1)
    ]

    def told(found):
        return {(t, frozenset((a[:2], b[:2]))): truth for (t, a, b), truth in found.items()}

    wanted = told(find_or_none(recording))
    for tables in (walks, renamed):
        other = recording.with_boxes(pd.concat(tables, ignore_index=True))
        assert_same(told(find_or_none(other)), wanted, abs_=0)


@given(seed=seeds, shift=st.integers(-5, 5000))
@settings(max_examples=20)
def test_another_clock_changes_the_frame_numbers_only(seed, shift):
    recording = scatter(seed, 7)
    moved = recording.with_boxes(recording.boxes.assign(frame=recording.boxes["frame"] + shift))
    wanted = {(t + shift, a, b): truth for (t, a, b), truth in find_or_none(recording).items()}
    assert find_or_none(moved) == wanted


@given(seed=seeds)
@settings(max_examples=20)
def test_stricter_rules_leave_fewer_pairs_and_occlusions(seed):
    recording = scatter(seed, 7)
    wide = find_or_none(recording)
    for rules in (Rules(seen=1), Rules(followed=0.9), Rules(apart=0)):
        narrow = find_or_none(recording, rules=rules)
        assert all(wide[key] == truth for key, truth in narrow.items())
    covered = find_or_none(recording, rules=Rules(cover=0.6))
    assert covered.keys() == wide.keys()
    for key, (yes, when, *_) in covered.items():
        assert not yes or (wide[key][0] and wide[key][1] <= when)
    longer = find_or_none(recording, rules=Rules(horizon=4, followed=0.45))
    for key in longer.keys() & wide.keys():
        assert not wide[key][0] or longer[key] == wide[key]


# Composites


def test_watching_sees_what_finding_sees_and_nothing_after():
    made = make_crossings(people=12, seconds=12.0, seed=4)
    known = find_pairs(made)
    moment = int(known.frame[len(known) // 2])
    before = made.boxes[made.boxes["frame"] <= moment].reset_index(drop=True)
    now = watch(made.with_boxes(before), moment)
    assert set(now.frame) == {moment}
    # Every pair of those who were seen well enough, also those that cover each other already.
    here = {person for row in now.people for person in row}
    assert len(now) == len(here) * (len(here) - 1) // 2
    names = [tuple(row) for row in now.people]
    for number in np.flatnonzero(known.frame == moment):
        same = names.index(tuple(known.people[number]))
        for name in ("x", "feet", "w", "h", "seen", "horizon", "rise"):
            seen, found = (getattr(one.walkers, name) for one in (now, known))
            np.testing.assert_array_equal(seen[now.who[same]], found[known.who[number]])


@pytest.mark.parametrize("frame", [0, 5, 10_000])
def test_watching_takes_two_walkers_seen_long_enough(frame):
    with pytest.raises(DatasetError, match=r"shows 0 walker.*Pass another frame"):
        watch(make_crossings(people=5, seconds=4.0, seed=1), frame)


def test_only_a_whole_frame_is_watched():
    with pytest.raises(ArgumentError, match=r"frame is 2\.5"):
        watch(make_crossings(people=5, seconds=4.0, seed=1), 2.5)


def walks(seed, *, subjects=None, rate=7):
    """Walks that begin at any frame and last 4 to 8 seconds, with gaps."""
    rng = np.random.default_rng(seed)
    recording = scatter(seed, rate, walkers=4, seconds=8.0)
    boxes = recording.boxes
    first = boxes.groupby("sequence", sort=False)["frame"].transform("first")
    last = boxes["sequence"].map({f"w{number}": rng.integers(28, 57) for number in range(4)})
    boxes = boxes[boxes["frame"] - first < last].reset_index(drop=True)
    if subjects:
        boxes["subject"] = boxes["sequence"].map(
            dict(zip(recording.sequences, subjects, strict=True))
        )
    return recording.with_boxes(boxes)


@given(seed=seeds, shift=st.sampled_from([0, 1, 3, 11]))
@settings(max_examples=25)
def test_composites_are_pairs_of_one_clock(seed, shift):
    recording = walks(seed)
    names = recording.sequences
    wanted, seen = {}, {}
    for one in names:
        for two in names:
            if one == two or (shift == 0 and one > two):
                continue
            composite = compose(recording, one, two, shift=shift)
            try:
                pairs = find_pairs(composite)
            except DatasetError:
                continue
            for key, truth in found_in(pairs, composite.sequences).items():
                wanted[key] = truth
            looks = seen_by_moment(composite, pairs)
            seen |= {(*key, one, two): look[:4] for key, look in looks.items()}
    try:
        pairs = lay_over(recording, shifts=[shift])
    except DatasetError:
        assert not wanted
        return
    names = np.array(names)
    assert (np.diff(pairs.now[:, ::-1], axis=1) == shift).all()
    keys = [
        (now + 1, *names[track].tolist())
        for now, track in zip(pairs.now[:, 0], pairs.track, strict=True)
    ]
    truth = zip(pairs.occludes.tolist(), pairs.seconds, pairs.x, pairs.y, strict=True)
    assert_same(dict(zip(keys, truth, strict=True)), wanted)
    walkers = pairs.walkers
    for key, who in zip(keys, pairs.who, strict=True):
        for name, row in zip(key[1:], who, strict=True):
            held = [v[row].tolist() for v in (walkers.x, walkers.feet, walkers.w, walkers.h)]
            assert held == seen[name, key[0], *key[1:]]


def test_nobody_is_laid_over_his_own_walk():
    def meetings(subjects):
        recording = walks(9, subjects=subjects)
        pairs = lay_over(recording, shifts=(0, 3))
        assert (pairs.people[:, 0] != pairs.people[:, 1]).all()
        return {frozenset(who) for who in np.array(recording.sequences)[pairs.track].tolist()}

    own = frozenset(("w0", "w2"))
    strangers = meetings(["ann", "bob", "dan", "cy"])
    assert own in strangers
    assert meetings(["ann", "bob", "ann", "cy"]) == strangers - {own}


def test_mirrored_copies_meet_others_but_not_their_own():
    recording = walks(5)
    labels = pd.Series(dict.fromkeys(recording.sequences, 2))
    both = add_mirrored(replace(recording, directions=labels))
    pairs = lay_over(both, shifts=(0,))
    met = {tuple(who) for who in np.array(both.sequences)[pairs.track].tolist()}
    stems = {frozenset(name[:2] for name in who) for who in met}
    assert all(len(stem) == 2 for stem in stems)
    mirrored = {name for who in met for name in who} & both.copies
    assert len(mirrored) == 4
    # Two copies meet where the two walks do, in the mirror.
    yes = {
        tuple(np.array(both.sequences)[track]): truth
        for track, truth in zip(pairs.track, pairs.occludes, strict=True)
    }
    copy = {name: name + next(iter(both.copies))[2:] for name in recording.sequences}
    plain = [who for who in yes if not set(who) & both.copies]
    assert plain
    assert all(yes[who] == yes[tuple(copy[name] for name in who)] for who in plain)


def test_composites_show_no_horizon():
    walkers = lay_over(walks(5), shifts=(0, 3)).walkers
    assert not walkers.rise.any()
    assert not walkers.horizon.any()


def test_shifts_add_up_whatever_their_order():
    recording = walks(5)
    one, two = (len(lay_over(recording, shifts=[shift])) for shift in (0, 3))
    for shifts in ((0, 3), (3, 0, 3), np.array([0, 3]), {0, 3}):
        assert len(lay_over(recording, shifts=shifts)) == one + two


@pytest.mark.parametrize("shifts", [[-1], [1.5], [True], None, ["a"], 2.0])
def test_only_whole_shifts_are_laid(shifts):
    with pytest.raises(ArgumentError, match=r"shifts is .* whole number"):
        lay_over(walks(5), shifts=shifts)


def test_no_shifts_are_refused():
    with pytest.raises(ArgumentError, match="shifts is empty"):
        lay_over(walks(5), shifts=[])


def test_a_shift_beyond_every_walk_makes_no_pair():
    with pytest.raises(DatasetError, match="made-up holds no pair"):
        lay_over(walks(5), shifts=[10**12])


def test_one_persons_walks_are_laid_over_each_other():
    alone = lay_over(walks(5, subjects=["ann"] * 4), shifts=[0])
    others = lay_over(walks(5, subjects=list("abcd")), shifts=[0])
    assert len(alone) == len(others)
    np.testing.assert_array_equal(alone.occludes, others.occludes)
    # Each walk is another person then.
    assert (alone.people[:, 0] != alone.people[:, 1]).all()


# Bad input


def test_one_walker_is_no_pair():
    every = np.arange(1, 61)
    with pytest.raises(DatasetError, match="made-up holds one walker, 'a'"):
        find_pairs(record({"a": (every, 10, 0, 10, 40)}))


def test_two_who_never_meet_in_time_are_no_pair():
    every = np.arange(1, 61)
    tracks = {"a": (every, 10, 0, 10, 40), "b": (every + 60, 50, 0, 10, 40)}
    with pytest.raises(DatasetError, match="made-up holds no pair"):
        find_pairs(record(tracks))


@pytest.mark.parametrize(("column", "value"), [("w", 0), ("h", 0), ("w", -3), ("h", -0.5)])
def test_boxes_without_size_are_refused(column, value):
    boxes = scatter(1, 10).boxes
    boxes.loc[17, column] = value
    with pytest.raises(TableError, match=r"row 17 .* must be positive"):
        Recording("made-up", boxes, 10, WIDTH, HEIGHT)


@pytest.mark.parametrize("rate", [0, -25, np.nan, np.inf, "25"])
def test_a_frame_rate_must_be_positive(rate):
    with pytest.raises(ArgumentError, match=r"frame_rate is .* above 0"):
        side_by_side(60, rate=rate)


def test_frames_out_of_order_are_refused():
    boxes = scatter(1, 10).boxes
    boxes.loc[3, "frame"] = boxes.loc[5, "frame"]
    with pytest.raises(TableError, match="repeated or unsorted frames in sequence 'w0'"):
        Recording("made-up", boxes, 10, WIDTH, HEIGHT)


@pytest.mark.parametrize("find", [find_pairs, lambda recording: lay_over(recording, shifts=[0])])
def test_a_frame_rate_too_low_for_the_rules_is_refused(find):
    with pytest.raises(DatasetError, match=r"made-up has 0.4 frames a second, hardly one in 1 s"):
        find(side_by_side(60, rate=0.4))


@pytest.mark.parametrize("rate", [0.5, 1])
def test_a_frame_a_second_is_a_moment_each(rate):
    pairs = find_pairs(side_by_side(10, rate=rate))
    assert (np.diff(pairs.frame) == 1).all()


def test_rules_too_short_for_a_frame_are_refused():
    with pytest.raises(DatasetError, match=r"hardly one in 0.01 s"):
        find_pairs(side_by_side(60), rules=Rules(observed=0.01))


@pytest.mark.parametrize("rules", [Rules(observed=1e7), Rules(horizon=1e7)])
def test_rules_longer_than_any_track_find_no_pair(rules):
    with pytest.raises(DatasetError, match="made-up holds no pair"):
        find_pairs(side_by_side(60), rules=rules)


def test_a_horizon_beyond_the_recording_needs_only_what_is_asked_for():
    found = find_or_none(side_by_side(60), rules=Rules(horizon=1e6, followed=0))
    assert [t for t, *_ in found] == [10, 20, 30, 40, 50, 60]


@pytest.mark.parametrize("name", ["observed", "horizon"])
@pytest.mark.parametrize("value", [0, -1, np.nan, np.inf, "1", None])
def test_rules_need_positive_times(name, value):
    with pytest.raises(ArgumentError, match=f"{name} is .* above 0"):
        Rules(**{name: value})


@pytest.mark.parametrize("name", ["cover", "apart", "seen", "followed"])
@pytest.mark.parametrize("value", [-0.1, 1.1, np.nan, "1"])
def test_rules_need_shares(name, value):
    with pytest.raises(ArgumentError, match=f"{name} is .* at least 0 and at most 1"):
        Rules(**{name: value})


def test_rules_do_not_take_pairs_that_occlude_already():
    with pytest.raises(ArgumentError, match=r"apart is 0.4, above cover, 0.3"):
        Rules(apart=0.4)
    assert Rules(1.0, 3.0, 0.3, 0.05, 0.8, 0.6) == RULES
