"""A control panel: a picture that follows its sliders.

A panel draws into an image widget rather than an output cell: the picture changes in place,
without flicker.
"""

import base64
import threading
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import cv2
import ipywidgets
import numpy as np
import traitlets
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mcnlab.cameras.floor import GridMap
from mcnlab.errors import McnError

LABEL_WIDTH = 150  # pixels
FORBIDDEN = "no camera may stand here:"


class Panel(ipywidgets.VBox):
    """Controls above a picture and a line of text.

    Parameters
    ----------
    draw : callable
        Called with the axes and the controls' values by name; draws, and returns the
        line of text.
    controls : dict
        Name → ipywidgets control.
    columns : int, optional
        How many axes, side by side.
    figsize : tuple of float, optional
        Inches.
    solid : tuple of int, optional
        Which of the axes are three-dimensional.
    margins : dict, optional
        As `matplotlib.figure.Figure.subplots_adjust` takes them.

    Attributes
    ----------
    picture : ipywidgets.Image
    text : ipywidgets.HTML
    controls : dict
    """

    def __init__(
        self,
        draw: Callable[..., str],
        controls: dict[str, ipywidgets.Widget],
        *,
        columns: int = 1,
        figsize: tuple[float, float] = (8, 3.6),
        solid: tuple[int, ...] = (),
        margins: dict[str, float] | None = None,
    ):
        self.draw = draw
        self.controls = controls
        self.picture = ipywidgets.Image(
            format="png", layout={"max_width": "calc(100% - 4px)", "align_self": "flex-start"}
        )
        self.text = ipywidgets.HTML()
        # Fixed margins: laying out anew at every move would cost as much as drawing.
        self._figure = Figure(figsize=figsize, dpi=80, layout="none")
        FigureCanvasAgg(self._figure)
        margins = {"left": 0.1, "right": 0.97, "bottom": 0.2, "top": 0.9, **(margins or {})}
        self._figure.subplots_adjust(**margins)
        # The axes stay and what is on them goes: making axes takes as long as drawing them.
        self._axes = [
            self._figure.add_subplot(
                1, columns, 1 + place, projection="3d" if place in solid else None
            )
            for place in range(columns)
        ]
        # JupyterLab sends slider moves through several threads of the kernel; one figure
        # can be drawn by one of them at a time.
        self._turn = threading.Lock()
        self._drawn = None
        for control in controls.values():
            control.observe(self._follow, names="value")
        super().__init__([*map(_in_line, controls.values()), self.text, self.picture])
        self._follow()

    def _repr_mimebundle_(self, **options):
        # The picture too, for those who read the notebook without running it.
        bundle = super()._repr_mimebundle_(**options)
        return {**bundle, "image/png": base64.b64encode(self.picture.value).decode()}

    def _follow(self, _change=None):
        with self._turn:
            values = {name: control.value for name, control in self.controls.items()}
            # A move that waited for its turn may have been overtaken and drawn already.
            if values != self._drawn:
                self._redraw(values)
                self._drawn = values

    def _redraw(self, values):
        for ax in self._axes:
            drawn = (*ax.lines, *ax.patches, *ax.texts, *ax.images, *ax.collections)
            for artist in (*drawn, *ax.child_axes):
                artist.remove()
            ax.set_prop_cycle(None)
            ax.relim()
        try:
            said = self.draw(*self._axes, **values)
        except McnError as fault:
            # What a slider asks may be impossible; the message says why.
            said = f"<b>{type(fault).__name__}</b>: {fault}"
        for ax in self._axes:
            ax.grid(False)  # a third of the drawing
        self._figure.canvas.draw()
        pixels = cv2.cvtColor(np.asarray(self._figure.canvas.buffer_rgba()), cv2.COLOR_RGBA2BGR)
        self.text.value = said
        # Packed lightly: the picture goes to a browser and is soon replaced.
        lightly = [cv2.IMWRITE_PNG_COMPRESSION, 1]
        self.picture.value = cv2.imencode(".png", pixels, lightly)[1].tobytes()


class CellPicker(ipywidgets.VBox):
    """Cells chosen on a map: a button a block, as they lie on the ground.

    Parameters
    ----------
    area : tuple of float
        Left, bottom, right, top, metres.
    block : float, optional
        Metres along a block's side; a sixteenth of the area's longer side if not given.
    text : str, optional
        What is chosen.

    Attributes
    ----------
    value : tuple of pairs
        Row and column of the chosen blocks, row 0 the lowest.
    """

    value = traitlets.Tuple()

    def __init__(self, area: tuple, *, block: float | None = None, text: str = FORBIDDEN):
        left, bottom, right, top = area
        self.map = GridMap.over(area, cell=block or max(right - left, top - bottom) / 16)
        self._buttons = {
            (row, column): ipywidgets.ToggleButton(
                tooltip=f"x {x:.1f} m, y {y:.1f} m",
                layout={"width": "22px", "height": "18px", "padding": "0"},
            )
            for row in range(self.map.rows)
            for column in range(self.map.columns)
            for x, y in [self.map.place_of(row, column)]
        }
        for cell, button in self._buttons.items():
            button.observe(partial(self._press, cell), names="value")
        lines = [
            ipywidgets.HBox([self._buttons[row, column] for column in range(self.map.columns)])
            for row in reversed(range(self.map.rows))
        ]
        super().__init__([ipywidgets.HTML(text), *lines])
        self.observe(self._show, names="value")

    def cells(self, grid: GridMap) -> np.ndarray:
        """Which cells of a grid lie in chosen blocks, shape (rows, columns)."""
        chosen = np.zeros(self.map.shape, bool)
        for row, column in self.value:
            chosen[row, column] = True
        left, bottom, right, top = self.map.area
        # The last cell's centre may lie beyond the map; the nearest block stands for it.
        x = np.clip(grid.centres()[0], left, np.nextafter(right, left))
        y = np.clip(grid.centres()[1], bottom, np.nextafter(top, bottom))
        return chosen[self.map.cell_of(*np.meshgrid(x, y))]

    def _press(self, cell, change):
        held = set(self.value) - {cell} | ({cell} if change["new"] else set())
        self.value = tuple(sorted(held))

    def _show(self, change):
        for cell, button in self._buttons.items():
            button.value = cell in change["new"]


def slider(text: str, low: int, high: int, value: int, *, step: int = 1) -> ipywidgets.IntSlider:
    """A slider over whole numbers."""
    return ipywidgets.IntSlider(value=value, min=low, max=high, step=step, **label(text))


def decimal_slider(
    text: str, low: float, high: float, value: float, *, step: float
) -> ipywidgets.FloatSlider:
    """A slider over decimal numbers."""
    return ipywidgets.FloatSlider(value=value, min=low, max=high, step=step, **label(text))


def menu(text: str, options: Collection) -> ipywidgets.Dropdown:
    """A list that folds out; its first is chosen."""
    return ipywidgets.Dropdown(options=options, **label(text))


def choices(text: str, options: Collection, *, value: Any = None) -> ipywidgets.ToggleButtons:
    """Buttons of which one is pressed; the first if no value is given."""
    style = {"button_width": "auto"}
    held = ipywidgets.ToggleButtons(options=options, description=text, style=style)
    if value is not None:
        held.value = value
    return held


def label(text: str) -> dict[str, Any]:
    """What a control says of itself, and how wide both are."""
    style = {"description_width": f"{LABEL_WIDTH}px"}
    return {"description": text, "style": style, "layout": {"width": "500px"}}


def _in_line(control):
    """A control with what it says of itself in front of it.

    Toggle buttons do not do that themselves: JupyterLab puts their description above them.
    """
    if not isinstance(control, ipywidgets.ToggleButtons):
        return control
    room = {"width": f"{LABEL_WIDTH}px", "margin": "2px 8px 2px 2px"}
    said = ipywidgets.Label(control.description, layout={**room, "justify_content": "flex-end"})
    control.description = ""
    return ipywidgets.HBox([said, control])
