"""The charts show what the tables say, and the arrows go where the walkers go."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.patches import Rectangle

from mcnlab.compass import DIRECTIONS, heading_of
from mcnlab.errors import ArgumentError
from mcnlab.occlusion.thesis import APART, BY_SPEED, CERTAIN, direction_table, look_up, speed_table
from mcnlab.plotting.occlusion import (
    FRAME_WIDTH,
    PACES,
    RULE_COLOURS,
    plot_direction_table,
    plot_forecast,
    plot_speed_table,
    plot_two_walkers,
)
from mcnlab.plotting.vision import plot_frame
from mcnlab.walking.speed import level_of

RULE_OF = {colour: rule for rule, colour in RULE_COLOURS.items()}
BOXES = [(200, 60, 40, 90), (60, 50, 40, 100)]  # the first one is on the right: S2


@pytest.fixture
def frame():
    """Axes that show a frame of 352 × 240."""
    return plot_frame(np.full((240, 352), 128, np.uint8))


def cells(ax, count):
    """The rules that the fills show, and the labels, row by row."""
    fills = np.full((count, count), -9)
    for patch in ax.patches:
        if isinstance(patch, Rectangle) and patch.get_gid() != "marked":
            column, row = np.array(patch.get_center()).astype(int) - 1
            fills[row, column] = RULE_OF[to_hex(patch.get_facecolor())]
    labels = {text.get_position(): text.get_text() for text in ax.texts}
    wanted = range(1, count + 1)
    return fills, [[labels[column, row] for column in wanted] for row in wanted]


def arrows(ax):
    """Start and end of every arrow."""
    drawn = [text for text in ax.texts if getattr(text, "arrow_patch", None)]
    return np.array([[text.xyann, text.xy] for text in drawn], dtype=float)


def words(ax):
    return [text.get_text() for text in ax.texts]


def legend(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_every_cell_of_table_3_1_is_drawn_and_labelled():
    fills, labels = cells(plot_direction_table(), 8)
    assert fills.tolist() == direction_table().tolist()
    names = {APART: "0", CERTAIN: "1", BY_SPEED: "P(O|S)"}
    assert labels == [[names[rule] for rule in row] for row in direction_table().tolist()]


@pytest.mark.parametrize("side", ["right", "left"])
def test_every_cell_of_tables_3_2_and_3_3_is_drawn_and_labelled(side):
    fills, labels = cells(plot_speed_table(side), 3)
    assert fills.tolist() == np.where(speed_table(side), BY_SPEED, APART).tolist()
    assert labels == [["C" if cell else "0" for cell in row] for row in speed_table(side)]


def test_the_fills_are_told_apart_in_grey():
    lightness = sorted(np.dot(to_rgb(c), [0.299, 0.587, 0.114]) for c in RULE_COLOURS.values())
    assert np.diff(lightness).min() > 0.15


def test_the_arrows_at_the_edges_point_as_seen_in_the_image():
    ways = np.diff(arrows(plot_direction_table()), axis=1)[:, 0]
    angles = np.radians(np.repeat(heading_of(DIRECTIONS), 2))  # a row's and a column's each
    assert len(ways) == 16
    unit = ways / np.hypot(*ways.T)[:, None]
    # Rows run downwards, so away is towards lesser rows.
    assert unit == pytest.approx(np.c_[np.sin(angles), -np.cos(angles)])


@pytest.mark.parametrize(("side", "sign"), [("right", 1), ("left", -1)])
def test_the_faster_have_the_longer_arrows(side, sign):
    ways = np.diff(arrows(plot_speed_table(side)), axis=1)[:, 0]
    assert (np.diff(sign * ways[::2, 0]) > 0).all()
    assert (sign * ways[:, 0] > 0).all()
    assert (ways[:, 1] == 0).all()


@pytest.mark.parametrize(
    ("draw", "cell"),
    [
        (lambda marked: plot_direction_table(marked=marked), (3, 7)),
        (lambda marked: plot_speed_table("left", marked=marked), (1, 3)),
    ],
)
def test_a_marked_cell_has_a_frame_in_its_row_and_column(draw, cell):
    (frame,) = [patch for patch in draw(cell).patches if patch.get_gid() == "marked"]
    assert frame.get_center().tolist() == [cell[1], cell[0]]
    assert not [patch for patch in draw(None).patches if patch.get_gid() == "marked"]


@pytest.mark.parametrize("marked", [(0, 1), (1, 9), (1,), 3, (1, 2, 3), "37", (1, np.nan)])
def test_no_other_cell_is_marked(marked):
    with pytest.raises(ArgumentError, match="two directions 1 to 8"):
        plot_direction_table(marked=marked)
    with pytest.raises(ArgumentError, match="two speed levels 1 to 3"):
        plot_speed_table("right", marked=marked)


def test_the_paces_lie_within_their_levels():
    for level, pace in PACES.items():
        assert level_of(pace * FRAME_WIDTH, frame_width=FRAME_WIDTH) == level


@pytest.mark.parametrize("level", [1, 2, 3])
@pytest.mark.parametrize("direction", DIRECTIONS)
def test_two_walkers_go_their_ways_for_three_seconds(direction, level):
    ax = plot_two_walkers(direction, 7, level, 3)
    (one, two) = np.diff(arrows(ax), axis=1)[:, 0]
    angle, reach = np.radians(heading_of(direction)), 3 * FRAME_WIDTH
    assert one == pytest.approx(
        PACES[level] * reach * np.array([np.sin(angle), -np.cos(angle)]), abs=1e-9
    )
    assert two == pytest.approx([-PACES[3] * reach, 0], abs=1e-9)
    assert f"S1  D{direction}  V{level}" in words(ax)
    assert "S2  D7  V3" in words(ax)


def test_the_title_over_two_walkers_is_the_tables_word():
    ax = plt.figure().add_subplot()
    for level1, level2 in [(3, 1), (1, 3)]:
        for one in DIRECTIONS:
            for two in DIRECTIONS:
                rule = look_up(one, two, level1, level2)
                ax.clear()
                title = plot_two_walkers(one, two, level1, level2, ax=ax).get_title(loc="left")
                assert title.startswith(
                    {APART: "no occ", CERTAIN: "certain", BY_SPEED: "by speed"}[int(rule)]
                )


def test_walkers_the_same_way_may_meet_in_the_frame_or_outside():
    assert plot_two_walkers(3, 3, 3, 1).get_title(loc="left") == "by speed: they meet"
    ax = plot_two_walkers(4, 4, 3, 2)
    assert ax.get_title(loc="left") == "by speed, but outside the frame: none"
    assert legend(ax) == ["foreseen: no occlusion"]


@pytest.mark.parametrize("given", [(0, 1, 1, 1), (1, 9, 1, 1), (1, 1, 4, 1), (1, 1, 1, 0)])
def test_no_walkers_for_other_cells(given):
    with pytest.raises(ArgumentError, match="pass whole numbers"):
        plot_two_walkers(*given)


def test_boxes_are_named_from_left_to_right_whatever_their_order(frame):
    plot_forecast(BOXES, (7, 3), (2, 1), seconds=1.26, place=(140, 100), ax=frame)
    assert words(frame) == ["S1  D3  V1", "S2  D7  V2"]
    assert [patch.get_bbox().bounds for patch in frame.patches] == [BOXES[1], BOXES[0]]
    assert [patch.get_linestyle() for patch in frame.patches] == ["-", "--"]


def test_time_and_place_are_those_foreseen_and_observed(frame):
    plot_forecast(
        BOXES, (7, 3), (2, 1), seconds=1.26, place=(140, 100), observed=(1.5, 150, 90), ax=frame
    )
    assert legend(frame) == ["foreseen in 1.3 s", "observed in 1.5 s"]
    assert [line.get_xydata().tolist() for line in frame.lines] == [[[140, 100]], [[150, 90]]]


def test_never_has_no_cross(frame):
    plot_forecast(BOXES, (7, 3), (2, 1), seconds=np.inf, place=(140, 100), ax=frame)
    assert legend(frame) == ["foreseen: no occlusion"]
    assert [line.get_xydata().tolist() for line in frame.lines] == [[]]


@pytest.mark.parametrize("place", [(-90, 100), (1000, 100), (140, -50), (140, 999)])
def test_a_place_outside_is_shown_at_the_edge_and_said_to_be(frame, place):
    plot_forecast(BOXES, (7, 3), (2, 1), seconds=4, place=place, ax=frame)
    ((x, y),) = frame.lines[0].get_xydata()
    assert 0 < x < 351
    assert 0 < y < 239
    assert legend(frame) == ["foreseen in 4.0 s, outside the frame"]


def test_a_forecast_without_a_frame_shows_both_boxes():
    ax = plot_forecast(BOXES, (7, 3), (2, 1), seconds=1, place=(140, 100))
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    assert left < 60 < 240 < right
    assert top < 50 < 150 < bottom  # rows run downwards


def test_a_label_stays_in_the_frame(frame):
    plot_forecast(
        [(0, 0, 20, 100), (340, 150, 12, 90)], (3, 7), (1, 1), seconds=1, place=(140, 100), ax=frame
    )
    frame.figure.canvas.draw()
    around = frame.get_window_extent()
    for text in frame.texts:
        box = text.get_window_extent()
        assert around.y0 <= box.y0 < box.y1 <= around.y1
        assert around.x0 <= box.x0 < box.x1 <= around.x1


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"boxes": [(1, 2, 3, 4)]}, "two finite boxes"),
        ({"boxes": [(1, 2, 3, 4), (1, 2, 0, 4)]}, "two finite boxes"),
        ({"boxes": [(1, 2, 3, 4), (1, 2, np.nan, 4)]}, "two finite boxes"),
        ({"directions": (1, 2, 3)}, "one number a box"),
        ({"levels": (1,)}, "one number a box"),
        ({"seconds": -1}, "seconds is -1"),
        ({"seconds": np.nan}, "seconds is nan"),
        ({"place": (np.nan, 1)}, "finite place"),
        ({"observed": (1, np.inf, 3)}, "observed is"),
        ({"observed": (1, 2)}, "observed is"),
    ],
)
def test_a_forecast_that_is_none_is_refused(frame, change, match):
    sound = {"boxes": BOXES, "directions": (7, 3), "levels": (2, 1), "seconds": 1}
    with pytest.raises(ArgumentError, match=match):
        plot_forecast(**{**sound, "place": (1, 2), **change}, ax=frame)
