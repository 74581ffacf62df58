"""Moving a slider changes the picture and what is said, and leaves nothing behind."""

import threading
import time

import ipywidgets
import numpy as np
import pytest

from mcnlab import widgets
from mcnlab.cameras.floor import GridMap
from mcnlab.widgets.panel import CellPicker, Panel


def moved_to(panel, **values):
    """A panel after its controls were moved."""
    for name, value in values.items():
        panel.controls[name].value = value
    return panel


MOVES = {
    "occlusion": {"cell": (3, 3), "level1": 1, "level2": 2, "seconds": 2.0},
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


@pytest.mark.parametrize("name", MOVES)
def test_every_control_redraws_and_can_be_taken_back(new_panel, name):
    panel = new_panel(name)
    assert set(MOVES[name]) == set(panel.controls)
    first = bytes(panel.picture.value), panel.text.value
    assert first[0].startswith(b"\x89PNG")
    for control, value in MOVES[name].items():
        before = panel.controls[control].value
        assert before != value
        moved_to(panel, **{control: value})
        moved = bytes(panel.picture.value), panel.text.value
        assert moved[0] != first[0], control
        assert "Error" not in moved[1], control
        moved_to(panel, **{control: before})
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
        moved_to(panel, **dict([value]))
        moved_to(panel, **{value[0]: before})
    assert artists(panel) == first
    assert panel._axes == axes == panel._figure.axes
    assert any(sum(kinds) for kinds in first)


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
