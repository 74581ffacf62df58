"""A control panel: a picture that follows its sliders.

A panel draws into an image widget rather than an output cell: the picture changes in place,
without flicker.
"""

import base64
import threading

import cv2
import ipywidgets
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mcnlab.errors import McnError


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

    Attributes
    ----------
    picture : ipywidgets.Image
    text : ipywidgets.HTML
    controls : dict
    """

    def __init__(self, draw, controls, *, columns=1, figsize=(8, 3.6)):
        self.draw = draw
        self.controls = controls
        self.picture = ipywidgets.Image(
            format="png", layout={"max_width": "100%", "align_self": "flex-start"}
        )
        self.text = ipywidgets.HTML()
        # Fixed margins: laying out anew at every move would cost as much as drawing.
        self._figure = Figure(figsize=figsize, dpi=80, layout="none")
        FigureCanvasAgg(self._figure)
        self._figure.subplots_adjust(left=0.1, right=0.97, bottom=0.2, top=0.9)
        # The axes stay and what is on them goes: making axes takes as long as drawing them.
        self._axes = [self._figure.add_subplot(1, columns, 1 + place) for place in range(columns)]
        # JupyterLab sends slider moves through several threads of the kernel; one figure
        # can be drawn by one of them at a time.
        self._turn = threading.Lock()
        self._drawn = None
        for control in controls.values():
            control.observe(self._follow, names="value")
        super().__init__([*controls.values(), self.text, self.picture])
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
            for artist in (*ax.lines, *ax.patches, *ax.texts, *ax.images):
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


def slider(text, low, high, value, *, step=1):
    """A slider over whole numbers."""
    return ipywidgets.IntSlider(
        value=value, min=low, max=high, step=step, **label(text, width="480px")
    )


def label(text, *, width="auto"):
    """What a control says of itself, and how wide it is."""
    style = {"description_width": "130px"}
    return {"description": text, "style": style, "layout": {"width": width}}
