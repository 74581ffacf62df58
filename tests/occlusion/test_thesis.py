"""Tables as printed, cell by cell; equations against geometry; nothing hangs on who is first."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcnlab.compass import DIRECTIONS, heading_of
from mcnlab.datasets.mirror import mirror_direction
from mcnlab.errors import ArgumentError
from mcnlab.occlusion.thesis import (
    APART,
    BY_SPEED,
    CERTAIN,
    SIDES,
    UNIDENTIFIED,
    Walker,
    direction_rules,
    direction_table,
    foresee,
    inconsistency,
    look_up,
    order_walkers,
    place_printed,
    place_reached,
    seconds_to_meet,
    speed_table,
)
from mcnlab.walking.speed import LEVELS

# Typed in from the thesis: rows S1, columns S2; P stands for P(O|S).
TABLE_3_1 = """
    0 0 0 0 0 1 1 1
    1 P P P 1 1 1 1
    1 P P P 1 1 1 1
    1 P P P 1 1 1 1
    0 0 0 0 0 1 1 1
    0 0 0 0 0 P P P
    0 0 0 0 0 P P P
    0 0 0 0 0 P P P
"""
TABLE_3_2 = """
    0 0 0
    C 0 0
    C C 0
"""
TABLE_3_3 = """
    0 C C
    0 0 C
    0 0 0
"""
PRINTED = {"0": APART, "1": CERTAIN, "P": BY_SPEED, "C": BY_SPEED}
# The captions of Figures 3.14 (a, b) and 3.15 (a to d); where one names no speeds, any do.
CASES = [
    ("3.14a", 3, 7, 3, 3, CERTAIN),
    ("3.14b", 3, 6, 3, 3, CERTAIN),
    ("3.15a", 2, 6, 2, 2, CERTAIN),
    ("3.15b", 3, 7, 2, 2, CERTAIN),
    ("3.15c", 3, 3, 3, 1, BY_SPEED),
    ("3.15d", 3, 3, 1, 1, APART),
]
FRAME = {"frame_width": 330, "frame_height": 240}  # levels part at 3.3 and 16.5: no whole p
TOWARD_FOR_AWAY = np.array([5, 4, 3, 2, 1, 8, 7, 6]) - 1  # 1 and 5, 2 and 4, 8 and 6 swapped
EPS = np.finfo(float).eps


def typed(table):
    return np.array([[PRINTED[cell] for cell in line.split()] for line in table.split("\n")[1:-1]])


def walker(x, y, vx, vy, direction=3, pixels=None):
    """Walkers who move (vx, vy) in one second."""
    x, y, vx, vy, direction = np.broadcast_arrays(x, y, vx, vy, direction)
    return Walker(x, y, direction, np.hypot(vx, vy) if pixels is None else pixels, vx, vy)


def flat(pair):
    return [float(value) for value in pair]


# --- Algorithm 1 ---------------------------------------------------------------------------


def test_s1_is_the_walker_with_the_lesser_abscissa():
    assert order_walkers([1, 5, 2.0], [3, 4, 2.0]).tolist() == [0, 1, UNIDENTIFIED]
    assert order_walkers(7, 3) == 1
    assert order_walkers([], []).tolist() == []


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=9))
def test_the_other_walker_is_s2_whoever_is_named_first(pairs):
    columns = np.array(pairs, float).reshape(-1, 2)
    here, there = order_walkers(*columns.T), order_walkers(*columns[:, ::-1].T)
    known = here != UNIDENTIFIED
    assert (known == (columns[:, 0] != columns[:, 1])).all()
    assert (there[known] == 1 - here[known]).all()
    assert (there[~known] == UNIDENTIFIED).all()
    rows = np.arange(len(columns))[known]
    assert (columns[rows, here[known]] < columns[rows, 1 - here[known]]).all()


def test_one_pair_in_one_column_is_refused():
    with pytest.raises(ArgumentError, match="no different subjects"):
        order_walkers(4, 4.0)


@pytest.mark.parametrize(
    ("x_p", "x_q", "match"),
    [
        ([1, np.nan], [1, 2], "x_p is nan"),
        (1, np.inf, "x_q is inf"),
        ([1, 2], [1, 2, 3], "shapes differ"),
        (1, [1], "shapes differ"),
        ("left", 2, "x_p holds what is no number"),
        (None, 2, "x_p is nan"),
        (1e7, 2, "x_p is 1e"),
        (1 + 2j, 2, "x_p holds what is no number"),
        ([[1], [1, 2]], 2, "x_p holds what is no number"),
    ],
)
def test_columns_that_are_none_are_refused(x_p, x_q, match):
    with pytest.raises(ArgumentError, match=match):
        order_walkers(x_p, x_q)


# --- Tables 3.1, 3.2, 3.3 ------------------------------------------------------------------


def test_table_3_1_is_the_printed_one_in_every_cell():
    assert direction_table().tolist() == typed(TABLE_3_1).tolist()


@pytest.mark.parametrize(("side", "table"), [("right", TABLE_3_2), ("left", TABLE_3_3)])
def test_tables_3_2_and_3_3_are_the_printed_ones_in_every_cell(side, table):
    assert speed_table(side).tolist() == (typed(table) == BY_SPEED).tolist()


def test_the_printed_rules_cover_every_cell_once():
    rules = direction_rules()
    assert {name: rule.sum() for name, rule in rules.items()} == {
        "approaching": 21,
        "departing": 25,
        "same way": 18,
    }
    assert (sum(rule.astype(int) for rule in rules.values()) == 1).all()


def test_without_its_exception_approaching_would_also_hold_where_departing_does():
    one, two = np.meshgrid(DIRECTIONS, DIRECTIONS, indexing="ij")
    approaching = np.isin(one, (1, 2, 3, 4, 5)) & np.isin(two, (1, 5, 6, 7, 8))
    both = approaching & direction_rules()["departing"]
    assert list(zip(one[both], two[both], strict=True)) == [(1, 1), (1, 5), (5, 1), (5, 5)]
    assert (direction_table()[both] == APART).all()


def test_away_and_toward_can_be_swapped():
    table = direction_table()
    assert (table[TOWARD_FOR_AWAY][:, TOWARD_FOR_AWAY] == table).all()
    for side in SIDES.values():
        assert set(TOWARD_FOR_AWAY[np.array(side) - 1] + 1) == set(side)


def test_in_a_mirror_the_tables_are_their_transposes():
    table, mirror = direction_table(), mirror_direction(np.array(DIRECTIONS)) - 1
    assert (table == table[mirror][:, mirror].T).all()
    assert (speed_table("left") == speed_table("right").T).all()


def test_no_table_has_another_side():
    with pytest.raises(ArgumentError, match="side is 'up'"):
        speed_table("up")


# --- both levels ---------------------------------------------------------------------------


def test_the_lookup_is_one_table_put_into_the_other():
    grid = np.meshgrid(DIRECTIONS, DIRECTIONS, LEVELS, LEVELS, indexing="ij")
    said = look_up(*grid)
    first, speeds = typed(TABLE_3_1), {"right": typed(TABLE_3_2), "left": typed(TABLE_3_3)}
    for one in DIRECTIONS:
        for two in DIRECTIONS:
            cell = np.full((3, 3), first[one - 1, two - 1])
            if cell[0, 0] == BY_SPEED:
                cell = speeds["right" if one in (2, 3, 4) else "left"]
            assert said[one - 1, two - 1].tolist() == cell.tolist()


@pytest.mark.parametrize(("figure", "d1", "d2", "v1", "v2", "code"), CASES)
def test_the_cases_of_the_thesis_come_out(figure, d1, d2, v1, v2, code):
    assert look_up(d1, d2, v1, v2) == code


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ((0, 1, 1, 1), "direction1 is 0"),
        ((1, 9, 1, 1), "direction2 is 9"),
        ((1, [1, 2.5], 1, 1), "direction2 "),
        ((np.nan, 1, 1, 1), "direction1 "),
        ((1, "away", 1, 1), "direction2 "),
        ((1, 1, 0, 1), "level1 is 0"),
        ((1, 1, 1, 4), "level2 is 4"),
        ((-1, 1, 1, 1), "direction1 is -1"),
        (([1, 2], [1, 2], [1, 2], [1]), "shapes differ"),
        ((3 + 0j, 1, 1, 1), "direction1 holds what is no number"),
        (([[1], [1, 2]], 1, 1, 1), "direction1 holds what is no number"),
    ],
)
def test_directions_and_levels_that_are_none_are_refused(given, match):
    with pytest.raises(ArgumentError, match=match):
        look_up(*given)


# --- Equations 3.1 to 3.6 ------------------------------------------------------------------


def test_approaching_walkers_share_the_distance_and_chasing_ones_eat_it_up():
    assert seconds_to_meet(100, 20, 30) == 2
    assert seconds_to_meet(100, 20, 30, same_way=True) == 10
    assert seconds_to_meet([100, 100], [20, 30], [30, 20], same_way=[False, True]).tolist() == [
        2,
        10,
    ]


def test_equal_speeds_the_same_way_and_walkers_who_stand_never_meet():
    assert seconds_to_meet(100, 20, 20, same_way=True) == np.inf
    assert seconds_to_meet(100, 0, 0) == np.inf
    assert seconds_to_meet(100, 5e-324, 0) == np.inf


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ((-1, 1, 1), "distance is -1"),
        ((1, -2, 1), "pixels1 is -2"),
        ((1, 1, np.nan), "pixels2 is nan"),
        ((1, [1, 1], [1, 1]), "shapes differ"),
    ],
)
def test_distances_and_speeds_that_are_none_are_refused(given, match):
    with pytest.raises(ArgumentError, match=match):
        seconds_to_meet(*given)


def test_same_way_must_be_one_answer_a_pair():
    with pytest.raises(ArgumentError, match="same_way"):
        seconds_to_meet([1, 2], [1, 2], [1, 1], same_way=[True, False, True])


whole = st.integers(-30, 30)
place = st.integers(0, 320)


@st.composite
def approaching(draw):
    """S1 with a slope and S2, anywhere; S1's motion is not square to the line between them."""
    x1, x2 = sorted(draw(st.lists(place, min_size=2, max_size=2, unique=True)))
    one = walker(x1, draw(place), draw(whole), draw(whole))
    two = walker(x2, draw(place), draw(whole), draw(whole))
    assume(one.vx != 0 and two.pixels > 0)
    assume((two.x - one.x) * one.vx + (two.y - one.y) * one.vy != 0)
    return one, two


def rounding(one, two):
    """How far the printed place may be off for rounding: ten roundings of Eq. 3.5's terms."""
    m, down, across = one.vy / one.vx, one.y - two.y, one.x - two.x
    terms = 2 * (abs(m * one.x) + one.y) * abs(down) + 2 * (across**2 + down**2)
    terms += one.x**2 + two.x**2 + one.y**2 + two.y**2
    return (1 + abs(m)) * 10 * EPS * terms / abs(2 * m * down + 2 * across) + 1e-9


@given(approaching(), st.booleans())
def test_the_printed_place_solves_3_4_and_the_difference_of_3_2_and_3_3(pair, same_way):
    one, two = pair
    assume(not same_way or one.pixels != two.pixels)
    x, y = place_printed(one, two, same_way=same_way)
    d = np.hypot(two.x - one.x, two.y - one.y)
    seconds = seconds_to_meet(d, one.pixels, two.pixels, same_way=same_way)
    off = rounding(one, two)
    d1, d2 = one.pixels * seconds, two.pixels * seconds
    # Nobody moves by more than 30 px either way.
    assert (y - one.y) * one.vx == pytest.approx((x - one.x) * one.vy, abs=60 * off)
    from1 = (x - one.x) ** 2 + (y - one.y) ** 2
    from2 = (x - two.x) ** 2 + (y - two.y) ** 2
    # A point moved by `off` changes the difference of its squared distances by 2·d·off; the
    # squares themselves are rounded at their own size.
    slack = 4 * d * off + 8 * EPS * (from1 + from2 + d1**2 + d2**2)
    assert from1 - from2 == pytest.approx(d1**2 - d2**2, abs=slack)


@given(approaching())
def test_the_printed_place_is_too_far_by_one_over_the_cosine(pair):
    one, two = pair
    d = np.hypot(two.x - one.x, two.y - one.y)
    d1 = one.pixels * seconds_to_meet(d, one.pixels, two.pixels)
    cosine = ((two.x - one.x) * one.vx + (two.y - one.y) * one.vy) / (d * one.pixels)
    x, y = place_printed(one, two)
    # abs: the point is off by `rounding`; rel: the cosine has a few roundings of its own.
    reach = d1 / cosine
    slack = 2 * rounding(one, two) + 40 * EPS * abs(reach) / abs(cosine)
    assert x == pytest.approx(one.x + reach * one.vx / one.pixels, abs=slack)
    assert y == pytest.approx(one.y + reach * one.vy / one.pixels, abs=slack)


@given(place, place, whole, whole, st.integers(1, 9), st.integers(1, 9), st.integers(1, 9))
def test_head_on_all_forms_agree_and_the_equations_are_consistent(x, y, vx, vy, far, fast1, fast2):
    assume(vx > 0)
    one = walker(x, y, fast1 * vx, fast1 * vy)
    two = walker(x + far * vx, y + far * vy, -fast2 * vx, -fast2 * vy)
    off = rounding(one, two)
    # They share the way in the proportion of their speeds.
    share = far * fast1 / (fast1 + fast2)
    meeting = [x + share * vx, y + share * vy]
    assert flat(place_printed(one, two)) == pytest.approx(meeting, abs=off)
    assert flat(place_reached(one, two, of="first")) == pytest.approx(meeting, abs=1e-9)
    assert flat(place_reached(one, two)) == pytest.approx(meeting, abs=1e-9)
    assert inconsistency(one, two) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("speed1", "speed2"), [(3, 1), (1, 3)])
def test_who_catches_up_on_the_same_line_does_so_ahead_of_both(speed1, speed2):
    one, two = walker(10, 20, 4 * speed1, 3 * speed1), walker(50, 50, 4 * speed2, 3 * speed2)
    way = {"same_way": True}
    # 50 px apart, 10 px/s closing: 5 s.  S2 as the chaser goes the other way (4, 3) → (−4, −3).
    if speed2 > speed1:
        one, two = (walker(w.x, w.y, -w.vx, -w.vy, 7) for w in (one, two))
    ends = [place_reached(one, two, **way), place_reached(one, two, of="first", **way)]
    meeting = [10 + 60, 20 + 45] if speed1 > speed2 else [50 - 60, 50 - 45]
    for end in [*ends, place_printed(one, two, **way)]:
        assert flat(end) == pytest.approx(meeting, abs=1e-9)
    assert inconsistency(one, two, **way) == pytest.approx(0, abs=1e-9)


@given(approaching())
def test_the_equations_contradict_each_other_by_the_law_of_cosines(pair):
    one, two = pair
    d = np.hypot(two.x - one.x, two.y - one.y)
    seconds = seconds_to_meet(d, one.pixels, two.pixels)
    d1, d2 = one.pixels * seconds, two.pixels * seconds
    cosine = ((two.x - one.x) * one.vx + (two.y - one.y) * one.vy) / (d * one.pixels)
    expected = np.sqrt(d2**2 + max(2 * d * d1 * (1 - cosine), 0)) - d2
    # Where S1 walks straight at S2 a root is taken of something rounded at 1e-11 px².
    assert inconsistency(one, two) == pytest.approx(expected, abs=1e-5)


def test_the_printed_place_runs_away_as_s1_turns_aside():
    # Two walkers 100 px apart at equal speeds: each walks 50 px.
    two = walker(200, 100, -20, 0)
    for degrees, printed, miss in [(0, 50, 0.0), (60, 100, 36.6), (80, 287.9, 53.7)]:
        way = np.radians(degrees)
        one = walker(100, 100, 20 * np.cos(way), 20 * np.sin(way))
        x, y = place_printed(one, two)
        assert np.hypot(x - 100, y - 100) == pytest.approx(printed, abs=0.05)
        x, y = place_reached(one, two, of="first")
        assert np.hypot(x - 100, y - 100) == pytest.approx(50)
        assert inconsistency(one, two) == pytest.approx(miss, abs=0.05)


def test_a_slope_does_not_know_that_s1_walks_off():
    two = walker(200, 100, -20, 0)
    toward, off = walker(100, 100, 20, 0), walker(100, 100, -20, 0)
    assert flat(place_printed(off, two)) == flat(place_printed(toward, two)) == [150, 100]
    assert flat(place_reached(off, two, of="first")) == [50, 100]
    assert inconsistency(off, two) == 100  # 150 px from S2, and not the 50 that S2 walks


def test_vertical_motion_has_a_place_but_no_slope():
    one, two = walker(100, 100, 0, -20), walker(200, 100, -20, 0)
    with pytest.raises(ArgumentError, match="no slope"):
        place_printed(one, two)
    assert flat(place_reached(one, two, of="first")) == [100, 50]
    assert flat(place_reached(one, two)) == [125, 75]


def test_motion_square_to_the_line_between_the_two_has_no_printed_place():
    one, two = walker([0, 100], [0, 100], [1, 20], [0, 20]), walker([9, 200], [0, 0], -1, 0)
    with pytest.raises(ArgumentError, match=r"square to the line between the two in pair 1"):
        place_printed(one, two)


def test_who_never_meets_has_no_place():
    one, two = walker(100, 100, 20, 0), walker(200, 100, 20, 0)
    for ask in (place_printed, place_reached, inconsistency):
        with pytest.raises(ArgumentError, match="never meet"):
            ask(one, two, same_way=True)


def test_s1_may_stand_still():
    one, two = walker(100, 100, 0, 0), walker(200, 100, -20, 0)
    assert flat(place_reached(one, two)) == [100, 100]
    assert inconsistency(one, two) == 0
    with pytest.raises(ArgumentError, match="no slope"):
        place_printed(one, two)


# --- everything together -------------------------------------------------------------------


def test_head_on_walkers_meet_when_and_where_they_must():
    one, two = walker(100, 120, 20, 0, 3), walker(200, 120, -30, 0, 7)
    said = foresee(one, two, **FRAME)
    assert said.occludes
    assert said.rule == CERTAIN
    assert flat(said[1:4]) == pytest.approx([2, 140, 120])


@pytest.mark.parametrize(
    ("x2", "p1", "p2", "occludes", "seconds", "x"),
    [
        (140, 20, 2, True, 40 / 18, 100 + 20 * 40 / 18),  # v3 behind v1: Figure 3.15 (c)
        (140, 2, 2, False, np.inf, 120),  # levels alike: Figure 3.15 (d)
        (140, 30, 20, False, np.inf, 120),  # levels alike, and yet they would meet in 4 s
        (140, 2, 20, False, np.inf, 120),  # the one ahead is faster
        (300, 20, 10, False, np.inf, 200),  # meets 400 px to the right: outside the frame
    ],
)
def test_the_same_way_speed_and_frame_decide(x2, p1, p2, occludes, seconds, x):
    said = foresee(walker(100, 120, p1, 0), walker(x2, 120, p2, 0), **FRAME)
    assert said.occludes == occludes
    assert flat(said[1:4]) == pytest.approx([seconds, x, 120])


def test_certain_occlusions_are_not_asked_to_stay_in_the_frame():
    one, two = walker(100, 120, -20, 0, 3), walker(120, 120, 20, 0, 7)
    assert foresee(one, two, of="first", **FRAME).occludes
    one, two = walker(10, 120, -20, 0, 3), walker(110, 120, 20, 0, 7)
    said = foresee(one, two, of="first", **FRAME)
    assert said.occludes
    assert said.x == -40


def test_the_frame_ends_half_a_pixel_beyond_its_outermost_centres():
    # S1 walks 20 px/s and closes in by 10: it meets S2 at twice the distance.
    for distance, occludes in [(114.75, True), (114.76, False)]:
        one, two = walker(100, 120, 20, 0), walker(100 + distance, 120, 10, 0)
        assert foresee(one, two, **FRAME).occludes == occludes


def test_walkers_in_one_column_are_not_told_apart_though_they_are_two():
    one = walker([50, 50], [20, 20], [0, 0], [20, 20], [5, 3])
    two = walker([50, 51], [200, 20], [0, -1], [-20, 0], [1, 7])
    said = foresee(one, two, **FRAME)
    assert said.rule.tolist() == [UNIDENTIFIED, CERTAIN]
    assert said.occludes.tolist() == [False, True]
    assert flat([said.seconds[0], said.x[0], said.y[0]]) == [np.inf, 50, 110]
    with pytest.raises(ArgumentError, match="no different subjects"):
        foresee(walker(50, 20, 0, 20), walker(50, 200, 0, -20), **FRAME)


def test_walkers_who_stand_never_meet_though_the_table_is_certain():
    said = foresee(walker(100, 120, 0, 0, 3), walker(200, 130, 0, 0, 7), **FRAME)
    assert (said.rule, said.occludes) == (CERTAIN, False)
    assert flat(said[1:4]) == [np.inf, 150, 125]


def test_no_pairs_are_no_forecasts():
    none = walker(*np.empty((4, 0)))
    said = foresee(none, none, **FRAME)
    assert [values.shape for values in said] == [(0,)] * 5


quarters = st.integers(0, 4 * 240).map(lambda value: value / 4)


@st.composite
def pairs(draw):
    """Pairs anywhere in the frame; nobody's direction need agree with its motion."""
    size = draw(st.integers(1, 6))
    both = []
    for _ in range(2):
        rows = [
            [
                draw(quarters),
                draw(quarters),
                draw(whole),
                draw(whole),
                draw(st.sampled_from(DIRECTIONS)),
            ]
            for _ in range(size)
        ]
        x, y, vx, vy, direction = np.array(rows).T
        both.append(walker(x, y, vx, vy, direction.astype(int)))
    return both


def assert_same(one, two, off=0.0):
    assert one.occludes.tolist() == two.occludes.tolist()
    assert one.rule.tolist() == two.rule.tolist()
    for name in ("seconds", "x", "y"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=off, atol=off)


@given(pairs(), st.sampled_from(["both", "first"]))
def test_exchanging_the_walkers_changes_nothing(both, of):
    here, there = foresee(*both, of=of, **FRAME), foresee(*both[::-1], of=of, **FRAME)
    assert_same(here, there)


@given(pairs())
def test_only_who_occludes_has_a_time_and_everybody_a_place(both):
    said = foresee(*both, **FRAME)
    assert (np.isfinite(said.seconds) == said.occludes).all()
    assert (said.seconds >= 0).all()
    assert np.isfinite([said.x, said.y]).all()
    assert np.isin(said.rule[said.occludes], (CERTAIN, BY_SPEED)).all()
    middle = [(both[0].x + both[1].x) / 2, (both[0].y + both[1].y) / 2]
    assert (np.array([said.x, said.y]) == middle)[:, ~said.occludes].all()


@given(pairs())
def test_each_pair_is_foreseen_by_itself(both):
    said = foresee(*both, **FRAME)
    for at in range(len(said.x)):
        alone = foresee(*(Walker(*(part[at : at + 1] for part in w)) for w in both), **FRAME)
        assert_same(alone, type(said)(*(values[at : at + 1] for values in said)))


def mirrored(walkers):
    x = FRAME["frame_width"] - 1 - walkers.x
    return walkers._replace(x=x, vx=-walkers.vx, direction=mirror_direction(walkers.direction))


@given(pairs())
def test_a_mirrored_scene_has_the_same_answer_and_the_mirrored_place(both):
    here, there = foresee(*both, **FRAME), foresee(*map(mirrored, both), **FRAME)
    # 1e-9: places of up to 10⁵ px (240·30 over the least difference of hypotenuses) in ε.
    edge = np.abs(there.x[there.rule == BY_SPEED] - (FRAME["frame_width"] - 1) / 2)
    assume((np.abs(edge - FRAME["frame_width"] / 2) > 1e-6).all())
    assert_same(here, there._replace(x=FRAME["frame_width"] - 1 - there.x), off=1e-9)


def test_with_the_end_of_s1_alone_the_mirrored_place_is_another():
    one, two = walker(100, 100, 0, -20, 1), walker(200, 100, -20, 0, 7)
    here = foresee(one, two, of="first", **FRAME)
    there = foresee(mirrored(one), mirrored(two), of="first", **FRAME)
    assert flat([here.x, here.y]) == [100, 50]
    assert flat([329 - there.x, there.y]) == [150, 100]


@given(pairs(), st.sampled_from([0.5, 2.0, 8.0]))
def test_scaling_the_image_changes_nothing_but_pixels(both, scale):
    # Pixels count from the centre of the first: the frame's corner is at −½.
    larger = [
        walker(
            scale * (w.x + 0.5) - 0.5, scale * (w.y + 0.5) - 0.5, scale * w.vx, scale * w.vy
        )._replace(direction=w.direction)
        for w in both
    ]
    here = foresee(*both, **FRAME)
    there = foresee(*larger, frame_width=scale * 330, frame_height=scale * 240)
    scaled = here._replace(x=scale * (here.x + 0.5) - 0.5, y=scale * (here.y + 0.5) - 0.5)
    assert_same(scaled, there, off=1e-9)


@pytest.mark.parametrize("direction1", DIRECTIONS)
def test_walkers_who_walk_as_their_directions_say_are_judged_by_the_table(direction1):
    others = np.array(DIRECTIONS)
    ways = np.radians(heading_of(others))
    two = walker(200, 120, 20 * np.sin(ways), -20 * np.cos(ways), others)
    way = np.radians(heading_of(direction1))
    one = walker(100, np.full(8, 120.0), 20 * np.sin(way), -20 * np.cos(way), direction1)
    said = foresee(one, two, **FRAME)
    assert (said.occludes == (direction_table()[direction1 - 1] == CERTAIN)).all()
    # 100 px apart, 20 px/s each.
    assert said.seconds[said.occludes].tolist() == pytest.approx([2.5] * said.occludes.sum())


@pytest.mark.parametrize(
    ("field", "value", "match"),
    [
        ("x", np.nan, r"first\.x is nan"),
        ("y", np.inf, r"first\.y is inf"),
        ("direction", 0, r"first\.direction is 0"),
        ("direction", 9, r"first\.direction is 9"),
        ("direction", np.nan, r"first\.direction "),
        ("pixels", -1, r"first\.pixels is -1"),
        ("pixels", "fast", r"first\.pixels holds what is no number"),
        ("vx", np.nan, r"first\.vx is nan"),
        ("vy", -np.inf, r"first\.vy is -inf"),
        ("x", [1, 2], "shapes differ"),
    ],
)
def test_walkers_that_are_none_are_refused(field, value, match):
    sound = walker(100, 120, 20, 0)
    with pytest.raises(ArgumentError, match=match):
        foresee(sound._replace(**{field: value}), walker(200, 120, 20, 0), **FRAME)


def test_who_moves_moves_some_way():
    with pytest.raises(ArgumentError, match=r"second travels .* vx and vy are 0 in pair 1"):
        foresee(
            walker([1, 2], 3, 4, 5),
            walker([5, 6], 7, 0, 0, pixels=np.array([0.0, 9.0])),
            **FRAME,
        )


@pytest.mark.parametrize("thing", [None, 3, (1, 2, 3), "walker"])
def test_what_is_no_walker_is_refused(thing):
    with pytest.raises(ArgumentError, match="second"):
        foresee(walker(100, 120, 20, 0), thing, **FRAME)


def test_as_many_first_as_second_walkers_are_wanted():
    with pytest.raises(ArgumentError, match="shapes differ: first"):
        foresee(walker([1, 2], 3, 4, 5), walker([1, 2, 3], 3, 4, 5), **FRAME)


@pytest.mark.parametrize("name", ["frame_width", "frame_height"])
@pytest.mark.parametrize("value", [0, -1, np.nan, None])
def test_a_frame_without_size_is_refused(name, value):
    with pytest.raises(ArgumentError, match=name):
        foresee(walker(1, 2, 3, 4), walker(5, 6, 7, 8), **{**FRAME, name: value})


@pytest.mark.parametrize("of", ["second", None])
def test_a_place_is_of_both_or_of_the_first(of):
    one, two = walker(1, 2, 3, 4), walker(5, 6, -7, 8)
    with pytest.raises(ArgumentError, match="of is"):
        place_reached(one, two, of=of)
    with pytest.raises(ArgumentError, match="of is"):
        foresee(one, two, of=of, **FRAME)
