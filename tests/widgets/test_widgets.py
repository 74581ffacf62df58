"""Moving a slider changes the picture and the accuracy, and says so when it cannot."""

import matplotlib

matplotlib.use("Agg")

import re
import threading
import time

import ipywidgets
import numpy as np
import pandas as pd
import pytest

from mcnlab import widgets
from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets.scene import Scene
from mcnlab.placement import votes
from mcnlab.placement.site import choose_cameras, judge_cameras, prepare_site
from mcnlab.synthetic.corridor import make_corridor
from mcnlab.synthetic.shifts import make_motion
from mcnlab.synthetic.walkers import make_walks
from mcnlab.vision import flow, recordings
from mcnlab.walking import direction, evaluation, gait, heading, phase, viewpoint
from mcnlab.widgets.panel import CellPicker, Panel
from mcnlab.widgets.walking import _overlap


@pytest.fixture(scope="module")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return recordings.casia_a()


@pytest.fixture(scope="module")
def masks():
    """A clean walk."""
    return make_walks(subjects=1, directions=(3,), seed=0)[0].masks


def panels(casia, masks):
    """Every panel with a control and two values for it."""
    return {
        "silhouette": (widgets.silhouette_panel(masks), "specks", (0, 60)),
        "mirror": (widgets.mirror_panel(casia), "every", (5, 20)),
        "phase": (widgets.phase_panel(casia), "prominence", (1.0, 6.0)),
        "separator": (widgets.separator_panel(casia), "prominence", (1.0, 6.0)),
        "heading": (widgets.heading_panel(casia, focal_length=450), "window", (12, 25)),
    }


def test_a_moved_slider_redraws_the_picture(casia, masks):
    for name, (panel, control, values) in panels(casia, masks).items():
        pictures = []
        for value in values:
            panel.controls[control].value = value
            pictures.append(bytes(panel.picture.value))
            assert pictures[-1].startswith(b"\x89PNG"), name
        assert pictures[0] != pictures[1], name


@pytest.mark.parametrize("dimension", ["h", "w"])
def test_the_separator_panel_says_the_judged_accuracy(casia, dimension):
    panel = widgets.separator_panel(casia)
    panel.controls["dimension"].value = dimension
    panel.controls["prominence"].value = 3.0
    measured = phase.measure_phases(casia.boxes, prominence=3.0)[f"m_{dimension}"]
    resubstituted, left_out = evaluation.judge_phase(casia, measured)
    said = [float(value) for value in re.findall(r"<b>([\d.]+)</b>", panel.text.value)]
    assert said == [round(resubstituted.value, 4), round(left_out.value, 4)]


def test_the_heading_panel_says_the_judged_accuracy(casia):
    panel = widgets.heading_panel(casia, focal_length=450)
    panel.controls["focal_length"].value = 380

    own = casia.without_copies()
    headings = heading.measure_headings(own, focal_length=380, window=25)
    right, _, _ = evaluation.judge_headings(own, headings)
    assert f"<b>{right.value:.3f}</b>" in panel.text.value


def test_what_cannot_be_is_said_in_words(casia, masks):
    panel = widgets.silhouette_panel(masks)
    assert "100%" in _with(panel, specks=0, holes=0, limbs=0, min_area=1).text.value
    few = casia.with_boxes(
        casia.boxes[casia.boxes["sequence"] == casia.sequences[0]].head(10).reset_index(drop=True),
        directions=casia.directions[casia.sequences[:1]],
        copies=frozenset(),
    )
    assert "ArgumentError" in widgets.heading_panel(few, focal_length=450).text.value


def test_readers_without_a_kernel_see_the_picture(masks):
    panel = widgets.silhouette_panel(masks)
    assert "image/png" in panel._repr_mimebundle_()


def test_moves_from_several_threads_take_turns():
    """JupyterLab may deliver two moves at once; no picture may be half of another."""
    inside, most = [], []

    def draw(ax, value):
        inside.append(value)
        most.append(len(inside))
        time.sleep(0.01)
        ax.plot([0, value])
        inside.pop()
        return str(value)

    panel = Panel(draw, {"value": ipywidgets.IntSlider(value=0, max=100)})
    threads = [
        threading.Thread(target=setattr, args=(panel.controls["value"], "value", value))
        for value in range(1, 9)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == 1
    assert panel.text.value == str(panel.controls["value"].value)


def test_mirror_panel_offers_the_oblique_walks(casia):
    panel = widgets.mirror_panel(casia)
    offered = panel.controls["sequence"].options
    assert set(direction.group_of(casia.directions[list(offered)])) == {2, 4}
    name = panel.controls["sequence"].value
    assert f"in direction {casia.directions[name]}" in panel.text.value


def _with(panel, **values):
    for name, value in values.items():
        panel.controls[name].value = value
    return panel


def test_overlap_is_intersection_over_union(masks):
    from mcnlab.vision.silhouettes import find_body

    body = find_body(masks[0])
    assert _overlap(body, body) == 1
    far = np.roll(masks[0], 120, axis=1)
    assert _overlap(body, find_body(far)) == 0


# Chapter 2


@pytest.fixture(scope="module")
def hall():
    """Four people who walk along y = 2, two each way, a metre a second."""
    along = 1 + np.arange(61) / 10
    walks = [
        pd.DataFrame(
            {
                "trace": f"w{number}",
                "frame": np.arange(61),
                "x": along[:: (-1) ** number],
                "y": 2 + 0.1 * number,
            }
        )
        for number in range(4)
    ]
    return Scene("hall", pd.concat(walks, ignore_index=True), 10, (0.0, 0.0, 8.0, 4.0))


@pytest.fixture(scope="module")
def corridor():
    """A few people in the made corridor."""
    return make_corridor(walkers=30, seed=1)


@pytest.fixture(scope="module")
def angled():
    """Two synthetic people from two view angles."""
    tables, truth = viewpoint.record_at_angles([0, 90], subjects=2)
    return tables[0], truth


@pytest.fixture(scope="module")
def moved():
    """Two frames of a made motion."""
    return make_motion("parting", shape=(48, 64))


MODEL = CameraModel(near=0.5, reach=4.0)

# Every new panel, and for each control a value that it does not begin with.
MOVES = {
    "gait": {"subject": "s02", "angle": 0},
    "flow": {"alpha": 30.0, "iterations": 5, "speed": 2.5, "pyramid": False},
    "vote": {
        "cell": 1.0,
        "chaos_ratio": 0.1,
        "least_traces": 5,
        "n": 1,
        "forbidden": ((3, 3), (4, 4)),
    },
    "choice": {
        "method": "area",
        "n": 1,
        "pans": True,
        "field_of_view": 30,
        "reach": 2,
        "square_within": 30,
        "forbidden": ((3, 3), (4, 4)),
    },
}


@pytest.fixture
def new_panel(hall, corridor, angled, moved):
    """new_panel(name): a panel of chapter 2."""
    make = {
        "gait": lambda: widgets.gait_panel(*angled, frame_rate=25),
        "flow": lambda: widgets.flow_panel((moved.first, moved.second)),
        "vote": lambda: widgets.vote_panel(corridor),
        "choice": lambda: widgets.choice_panel(hall, model=MODEL),
    }
    return lambda name: make[name]()


@pytest.mark.parametrize("name", MOVES)
def test_every_control_redraws_and_can_be_taken_back(new_panel, name):
    panel = new_panel(name)
    assert set(MOVES[name]) == set(panel.controls)
    first = bytes(panel.picture.value), panel.text.value
    assert first[0].startswith(b"\x89PNG")
    for control, value in MOVES[name].items():
        before = panel.controls[control].value
        assert before != value
        _with(panel, **{control: value})
        moved = bytes(panel.picture.value), panel.text.value
        assert moved[0] != first[0], control
        assert "Error" not in moved[1], control
        _with(panel, **{control: before})
        assert (bytes(panel.picture.value), panel.text.value) == first, control


def artists(panel):
    """How many artists of each kind lie on each axes."""
    return [
        [len(kind) for kind in (ax.lines, ax.collections, ax.patches, ax.texts, ax.images)]
        + [len(ax.child_axes)]
        for ax in panel._axes
    ]


@pytest.mark.parametrize("name", MOVES)
def test_moves_leave_nothing_behind(new_panel, name):
    panel = new_panel(name)
    axes, first = list(panel._axes), artists(panel)
    for value in list(MOVES[name].items()) * 2:
        before = panel.controls[value[0]].value
        _with(panel, **dict([value]))
        _with(panel, **{value[0]: before})
    assert artists(panel) == first
    assert panel._axes == axes == panel._figure.axes
    assert any(sum(kinds) for kinds in first)


def test_the_vote_panel_draws_its_mesh_in_space(new_panel):
    panel = new_panel("vote")
    mesh, plan = panel._axes
    assert (mesh.name, plan.name) == ("3d", "rectilinear")
    heights = []
    for cell in (0.3, 2.0, 0.5):
        _with(panel, cell=cell)
        heights.append(mesh.zz_dataLim.intervalx[1])
        assert panel.text.value.endswith(f"most votes in one cell: {heights[-1]:g}")
    assert heights[0] > heights[2] > heights[1]  # no height is left from the move before
    assert panel._axes == [mesh, plan]


def test_the_gait_panel_says_the_rhythm_it_shows(new_panel, angled):
    boxes, truth = angled
    panel = new_panel("gait")
    assert panel.controls["angle"].options == (0, 90)
    for subject in ("s01", "s02"):
        _with(panel, subject=subject, angle=90)
        name = truth.index[(truth["angle"] == 90) & (truth["subject"] == subject)][0]
        walk = boxes[boxes["sequence"] == name]
        period = gait.rhythm_of(walk, frame_rate=25)[2]
        assert panel.text.value.startswith(f"σ = 90°: step <b>{period.step:.2f} s</b>")
        assert f"true step {truth.step_s[name]:.2f} s" in panel.text.value
        np.testing.assert_array_equal(panel._axes[0].lines[0].get_ydata(), walk["w"])


@pytest.mark.parametrize("angles", [[90], [0, 45]])
def test_the_gait_panel_begins_within_its_angles(angles):
    tables, truth = viewpoint.record_at_angles(angles, subjects=1)
    panel = widgets.gait_panel(tables[0], truth, frame_rate=25)
    assert panel.controls["angle"].value == max(angles)
    assert f"σ = {max(angles)}°" in panel.text.value


def test_the_flow_panel_says_how_much_moves(new_panel, moved):
    panel = _with(new_panel("flow"), alpha=10.0, iterations=30, speed=1.0)
    motion = flow.horn_schunck(moved.first, moved.second, alpha=10.0, iterations=30)
    mask = flow.moving_mask(motion, speed=1.0)
    assert f"<b>{np.mean(mask > 0):.1%}</b>" in panel.text.value
    np.testing.assert_array_equal(panel._axes[1].images[0].get_array() == 0, mask > 0)
    _with(panel, pyramid=False)
    motion = flow.horn_schunck_plain(moved.first, moved.second, alpha=10.0, iterations=30)
    assert f"<b>{np.mean(flow.moving_mask(motion, speed=1.0) > 0):.1%}</b>" in panel.text.value


def test_the_vote_panel_says_what_the_votes_say(new_panel, corridor):
    panel = _with(new_panel("vote"), cell=0.8, n=1, forbidden=((4, 3), (5, 3)))
    grid = GridMap.over(corridor.area, cell=0.8)
    barred = panel.controls["forbidden"].cells(grid)
    placed = votes.place_by_votes(corridor.traces, grid, n=1, forbidden=barred)
    assert f"<b>humps: {len(placed.humps)}</b>" in panel.text.value
    without, directed, chaos = np.bincount(placed.cells.kind.ravel(), minlength=3)
    said = f"{directed} directed cells, {chaos} chaos, {without} without a locus"
    assert said in panel.text.value
    assert panel.text.value.endswith(f"one cell: {placed.votes.max()}")
    places = panel._axes[1].lines[-1].get_xydata()
    np.testing.assert_array_equal(places, placed.places[["x", "y"]])


@pytest.mark.parametrize("method", ["swaps", "exact", "greedy", "votes", "area"])
def test_the_choice_panel_says_what_its_cameras_see(new_panel, hall, method):
    panel = _with(new_panel("choice"), method=method, n=2, reach=3)
    model = CameraModel(near=0.5, reach=3)
    site = prepare_site(hall, model=model)
    cameras, choice = choose_cameras(site, method, 2)
    seen = judge_cameras(cameras, site.targets, model=model)
    said = f"seen square-on: <b>{seen.mean():.3f}</b> of {len(seen)} walker-seconds"
    assert panel.text.value.startswith(said)
    assert ("none sees more" in panel.text.value) == (choice is not None)
    stand = panel._axes[0].lines[-1].get_xydata()
    np.testing.assert_array_equal(stand, cameras[["x", "y"]])


def test_the_choice_panel_begins_with_the_model(hall):
    for pans in (True, False):
        model = CameraModel(45.0, 0.5, 6.0, pans, 20.0)
        controls = widgets.choice_panel(hall, model=model).controls
        begun = [controls[name].value for name in ("field_of_view", "reach", "pans")]
        assert begun == [45, 6, pans]
        assert controls["square_within"].value == 20


def every_block(panel):
    """All blocks of a panel's map."""
    rows, columns = panel.controls["forbidden"].map.shape
    return tuple((row, column) for row in range(rows) for column in range(columns))


def test_impossible_wishes_are_answered_in_words(new_panel):
    panel = new_panel("vote")
    most = tuple(block for block in every_block(panel) if block[1] > 5)
    _with(panel, n=8, cell=2.0, forbidden=most)
    assert panel.text.value.startswith("<b>ArgumentError</b>: n is 8")
    _with(panel, n=1, forbidden=every_block(panel))
    assert panel.text.value.startswith("<b>ArgumentError</b>: forbidden and votes leave no place")
    assert "humps" in _with(panel, forbidden=()).text.value
    panel = new_panel("choice")
    _with(panel, forbidden=every_block(panel))
    assert "leaves no place for a camera" in panel.text.value
    assert "seen square-on" in _with(panel, forbidden=()).text.value
    assert bytes(panel.picture.value).startswith(b"\x89PNG")


def test_frames_of_two_sizes_are_answered_in_words(moved):
    panel = widgets.flow_panel((moved.first, moved.second[:-1]))
    assert "ArgumentError" in panel.text.value


def test_a_pressed_button_chooses_its_block():
    picker = CellPicker((0.0, 0.0, 4.0, 2.0), block=1.0, text="here:")
    heard = []
    picker.observe(lambda change: heard.append(change["new"]), names="value")
    assert picker.value == ()
    picker._buttons[1, 3].value = True
    picker._buttons[0, 0].value = True
    assert picker.value == ((0, 0), (1, 3))
    picker._buttons[1, 3].value = False
    assert picker.value == ((0, 0),)
    assert heard == [((1, 3),), ((0, 0), (1, 3)), ((0, 0),)]


def test_the_buttons_lie_as_the_blocks_on_the_ground():
    picker = CellPicker((0.0, 0.0, 4.0, 2.0), block=1.0, text="here:")
    _, upper, lower = picker.children
    assert list(upper.children) == [picker._buttons[1, column] for column in range(4)]
    assert list(lower.children) == [picker._buttons[0, column] for column in range(4)]
    assert lower.children[3].tooltip == "x 3.5 m, y 0.5 m"


def test_a_set_value_presses_the_buttons():
    picker = CellPicker((0.0, 0.0, 4.0, 2.0), block=1.0, text="here:")
    picker.value = ((0, 1), (1, 2))
    pressed = {cell for cell, button in picker._buttons.items() if button.value}
    assert pressed == {(0, 1), (1, 2)}
    picker.value = ((1, 2), (0, 3))  # in any order
    assert picker.value == ((0, 3), (1, 2))
    picker.value = ()
    assert not any(button.value for button in picker._buttons.values())


def test_blocks_are_mapped_to_the_cells_whose_centres_they_hold():
    picker = CellPicker((0.0, 0.0, 4.0, 2.0), block=1.0, text="here:")
    picker.value = ((1, 3),)
    cells = picker.cells(GridMap(0.0, 0.0, 4, 8, 0.5))
    assert np.argwhere(cells).tolist() == [[2, 6], [2, 7], [3, 6], [3, 7]]
    assert picker.cells(GridMap(0.0, 0.0, 1, 2, 2.0)).tolist() == [[False, True]]  # (3, 1)
    assert not picker.cells(GridMap(0.0, 0.0, 1, 1, 4.0)).any()  # (2, 2), nearest to (2.5, 1.5)


@pytest.mark.parametrize("cell", [0.3, 0.5, 0.7, 1.1, 1.7])
def test_all_blocks_are_all_cells(cell):
    area = (0.0, 0.0, 11.5, 5.0)
    picker = CellPicker(area, block=11.5 / 16, text="here:")
    picker.value = tuple(sorted(picker._buttons))
    assert picker.cells(GridMap.over(area, cell=cell)).all()
    picker.value = ()
    assert not picker.cells(GridMap.over(area, cell=cell)).any()
