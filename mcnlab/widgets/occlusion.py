"""The panel of sections 3.3 and 3.5: point at a cell of the tables and see two people walk."""

from functools import partial

import ipywidgets
import numpy as np
import traitlets
from matplotlib.colors import to_rgb

from mcnlab.compass import DIRECTIONS, NAMES
from mcnlab.occlusion import thesis
from mcnlab.occlusion.thesis import APART, BY_SPEED, CERTAIN
from mcnlab.plotting import occlusion as plots
from mcnlab.plotting.occlusion import FRAME_HEIGHT, FRAME_WIDTH, RULE_COLOURS
from mcnlab.plotting.style import INK, WALKER_LINES, frame_axes
from mcnlab.walking.speed import LEVELS
from mcnlab.walking.speed import NAMES as SPEED_NAMES
from mcnlab.widgets.panel import Panel, choices, decimal_slider

_PLACES = 0.35 * FRAME_WIDTH, 0.65 * FRAME_WIDTH  # where S1 and S2 begin
_BODY = 28, 72  # pixels, a box
_OUTLINE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) / 2  # a box of side 1

_SAID = {
    APART: "0: no occlusion",
    BY_SPEED: "C: time and place decide",
    CERTAIN: "1: certain occlusion",
}


class TablePicker(ipywidgets.VBox):
    """Table 3.1 as buttons: the pressed one is the cell that is looked at.

    Attributes
    ----------
    value : tuple of int
        D(S1) and D(S2), 1 … 8.
    """

    value = traitlets.Tuple()

    def __init__(self, value: tuple[int, int] = (3, 7)):
        table = thesis.direction_table()
        self._buttons = {}
        # Room for the frame of the pressed one: its text stays whole, and in its place.
        size = {"width": "54px", "height": "28px", "padding": "0", "margin": "1px"}
        centred = {**size, "justify_content": "center"}
        heads = [ipywidgets.Label(str(two), layout=centred) for two in DIRECTIONS]
        lines = [_line("D(S1) ↓  D(S2) →", heads)]
        for one in DIRECTIONS:
            for two in DIRECTIONS:
                code = int(table[one - 1, two - 1])
                button = ipywidgets.Button(
                    description=plots.RULE_LABELS[code],
                    tooltip=f"S1 {NAMES[one]}, S2 {NAMES[two]}",
                    style={
                        "button_color": RULE_COLOURS[code],
                        "text_color": plots.RULE_INK[code],
                    },
                    layout=size,
                )
                button.on_click(partial(self._press, (one, two)))
                self._buttons[one, two] = button
            lines.append(
                _line(f"{one} {NAMES[one]}", [self._buttons[one, two] for two in DIRECTIONS])
            )
        super().__init__(lines)
        self.observe(self._show, names="value")
        self.value = value

    def _press(self, cell, _button):
        self.value = cell

    def _show(self, change):
        for cell in (change["old"], change["new"]):
            if cell in self._buttons:
                chosen = cell == change["new"]
                self._buttons[cell].layout.border = f"2px solid {INK}" if chosen else ""
                self._buttons[cell].style.font_weight = "bold" if chosen else ""


def occlusion_panel() -> Panel:
    """Point at a cell of Table 3.1, choose both speeds, and walk the clock on.

    The walkers begin where they are drawn, each at one pace within its speed level; the
    dots are where Equation 3.1 and the motion of both put them.

    Examples
    --------
    >>> panel = occlusion_panel()
    >>> panel.controls["cell"].value = (3, 7)
    >>> panel.text.value.split("; ")[2]
    't = d / |p1 + p2| = 106 / |28 + 28| = <b>1.9 s</b>, at (176, 120)'
    """

    def draw(left, right, cell, level1, level2, seconds):
        walkers = [
            plots.made_walker(x, (FRAME_HEIGHT - 1) / 2, direction, level)
            for x, direction, level in zip(_PLACES, cell, (level1, level2), strict=True)
        ]
        said = thesis.foresee(*walkers, frame_width=FRAME_WIDTH, frame_height=FRAME_HEIGHT)
        _draw_table(left, cell, (level1, level2))
        _draw_walkers(right, walkers, seconds)
        if said.occludes:
            right.plot(said.x, said.y, "X", ms=11, color=plots.FORESEEN, mec=INK)
            right.set_title(f"after {seconds:.1f} s; cross: foreseen", fontsize=10)
        return _say(cell, (level1, level2), walkers, said)

    speeds = [(SPEED_NAMES[level], level) for level in LEVELS]
    panel = Panel(
        draw,
        {
            "cell": TablePicker(),
            "level1": choices("V(S1)", speeds, value=3),
            "level2": choices("V(S2)", speeds, value=3),
            "seconds": decimal_slider("seconds", 0.0, 8.0, 0.0, step=0.1),
        },
        columns=2,
        figsize=(9, 3.4),
        margins={"left": 0.05, "bottom": 0.2, "right": 0.98, "top": 0.88},
    )
    # Table and speeds side by side, so that the picture stays in view.
    table, *others, text, picture = panel.children
    others = ipywidgets.VBox(others, layout={"justify_content": "center"})
    panel.children = (
        ipywidgets.HBox([table, others], layout={"flex_flow": "row wrap"}),
        text,
        picture,
    )
    return panel


def _draw_table(ax, cell, levels):
    """The table that decides, small, its cell marked: 3.1, or where speed decides 3.2 or 3.3."""
    table, ticks, labels, of, number = thesis.direction_table(), DIRECTIONS, DIRECTIONS, "D", "3.1"
    if table[cell[0] - 1, cell[1] - 1] == BY_SPEED:
        side = "right" if cell[0] in thesis.SIDES["right"] else "left"
        number = "3.2" if side == "right" else "3.3"
        table = np.where(thesis.speed_table(side), BY_SPEED, APART)
        ticks, labels, of, cell = LEVELS, list(SPEED_NAMES.values()), "V", levels
        for (row, column), code in np.ndenumerate(table):
            ax.text(
                column + 1,
                row + 1,
                "C" if code == BY_SPEED else "0",
                ha="center",
                va="center",
            )
    count = len(table)
    image = np.array([to_rgb(RULE_COLOURS[code]) for code in table.ravel()])
    end = count + 0.5
    ax.imshow(image.reshape(count, count, 3), extent=(0.5, end, end, 0.5))
    ax.set_title(f"Table {number}", fontsize=10)
    one, two = cell
    for colour, width in (("white", 5), (INK, 2)):
        ax.plot(*np.add(_OUTLINE, (two, one)).T, color=colour, lw=width)
    ax.set_xticks(ticks, labels)
    ax.set_yticks(ticks, labels)
    ax.set(xlabel=f"{of}(S2)", ylabel=f"{of}(S1)")


def _draw_walkers(ax, walkers, seconds):
    """Where both began, the way they went and where they are now."""
    frame_axes(ax, FRAME_WIDTH, FRAME_HEIGHT)
    for walker, colour, style, name in zip(
        walkers, plots.WALKER_COLOURS, WALKER_LINES, ("S1", "S2"), strict=True
    ):
        x, y = walker.x + seconds * walker.vx, walker.y + seconds * walker.vy
        ax.plot([walker.x, x], [walker.y, y], color=colour, lw=1, ls=":")
        ax.plot(*(_OUTLINE * _BODY + (x, y)).T, color=colour, ls=style)
        # A second's way, at least long enough to be seen.
        way = np.array([walker.vx, walker.vy])
        way = way * max(1.0, 14 / np.hypot(*way))
        ax.annotate(
            "",
            xy=(x + way[0], y + way[1]),
            xytext=(x, y),
            arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2, "shrinkA": 0, "shrinkB": 0},
            annotation_clip=True,
        )
        ax.text(x, y - _BODY[1] / 2 - 4, name, color=colour, ha="center", clip_on=True)
    ax.set_title(f"after {seconds:.1f} s", fontsize=10)


def _say(cell, levels, walkers, said):
    """What the tables and equations say of a cell."""
    rule = int(thesis.look_up(*cell, *levels))
    what = _SAID[rule]
    if rule == APART and thesis.direction_table()[cell[0] - 1, cell[1] - 1] == BY_SPEED:
        what = "P(O|S), and by speed 0: no occlusion"
    text = (
        f"S1 {cell[0]} {NAMES[cell[0]]}, {SPEED_NAMES[levels[0]]}; "
        f"S2 {cell[1]} {NAMES[cell[1]]}, {SPEED_NAMES[levels[1]]}: <b>{what}</b>"
    )
    if rule == APART:
        return text
    if not said.occludes:
        return f"{text}; the place lies outside the frame: <b>none</b>"
    p1, p2 = (walker.pixels for walker in walkers)
    distance = walkers[1].x - walkers[0].x
    sign = "+" if rule == CERTAIN else "−"
    return (
        f"{text}; t = d / |p1 {sign} p2| = {distance:.0f} / |{p1:.0f} {sign} {p2:.0f}| = "
        f"<b>{said.seconds:.1f} s</b>, at ({said.x:.0f}, {said.y:.0f})"
    )


def _line(text, widgets):
    room = {"width": "120px", "justify_content": "flex-end", "margin": "0 8px 0 0"}
    return ipywidgets.HBox([ipywidgets.Label(text, layout=room), *widgets])
