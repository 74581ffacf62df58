"""The panels of chapter 2: from a video seen from above to camera places."""

import ipywidgets
import numpy as np

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.errors import ArgumentError
from mcnlab.figures.placement import draw_cells
from mcnlab.placement import cells, votes
from mcnlab.placement.site import choose_cameras, grid_over, judge_cameras, no_floor, prepare_site
from mcnlab.plotting.placement import (
    plot_cameras,
    plot_forbidden,
    plot_ground,
    plot_mesh,
    plot_served,
)
from mcnlab.plotting.style import UPPER
from mcnlab.tables import X, Y
from mcnlab.widgets.panel import CellPicker, Panel, choices, decimal_slider, slider

PATIENCE = 2.0  # s; a proof that takes longer is cut short, and the bound says so


def vote_panel(scene):
    """Cell size, chaos rule, cameras and forbidden cells; the mesh and the plan follow.

    Parameters
    ----------
    scene : Scene
    """
    left, bottom, right, top = scene.area
    picker = CellPicker(
        scene.area, block=max(right - left, top - bottom) / 16, text="no camera may stand here:"
    )
    held = {}

    def draw(mesh, plan, cell, chaos_ratio, least_traces, n, forbidden):
        if cell not in held:
            grid = GridMap.over(scene.area, cell=cell)
            held[cell] = grid, cells.orientations(scene.traces, grid)
        grid, angles = held[cell]
        barred = picker.cells(grid)
        placed = votes.place_by_votes(
            scene.traces,
            grid,
            n=n,
            chaos_ratio=chaos_ratio,
            least_traces=least_traces,
            forbidden=barred | no_floor(scene, grid),
            angles=angles,
        )
        plot_mesh(grid, placed.votes, most=24, ax=mesh)
        plot_ground(grid.area, walls=scene.walls, ax=plan)
        draw_cells(grid, placed.cells, ax=plan)
        plot_forbidden(grid, barred, ax=plan)
        plan.plot(placed.places[X], placed.places[Y], "^", ms=11, color=UPPER, mec="white")
        counts = np.bincount(placed.cells.kind.ravel(), minlength=3)
        return (
            f"<b>humps: {len(placed.humps)}</b>; cameras at "
            f"{', '.join(f'({hump.row}, {hump.column})' for hump in placed.places.itertuples())}; "
            f"{counts[cells.DIRECTED]} directed cells, "
            f"{counts[cells.CHAOS]} chaos, {counts[cells.NO_LOCUS]} without a locus; "
            f"most votes in one cell: {placed.votes.max()}"
        )

    return Panel(
        draw,
        {
            "cell": decimal_slider("cell (m)", 0.3, 2, 0.5, step=0.1),
            "chaos_ratio": decimal_slider("chaos ratio", 0.1, 1, cells.CHAOS_RATIO, step=0.05),
            "least_traces": slider("minimum traces", 1, 20, 1),
            "n": slider("cameras", 1, 8, 2),
            "forbidden": picker,
        },
        columns=2,
        figsize=(11, 3.8),
        solid=(0,),
        margins={"left": 0.02, "bottom": 0.14, "wspace": 0.2},
    )


def choice_panel(scene, *, model):
    """Number of cameras, what each can see, and where none may stand; the plan follows.

    Parameters
    ----------
    scene : Scene
    model : coverage.CameraModel
        To begin with.
    """
    left, bottom, right, top = scene.area
    picker = CellPicker(
        scene.area, block=max(right - left, top - bottom) / 16, text="no camera may stand here:"
    )
    grid = grid_over(scene.area)
    held = {}

    def draw(plan, method, n, pans, field_of_view, reach, square_within, forbidden):
        wanted = CameraModel(field_of_view, min(model.near, reach / 2), reach, pans, square_within)
        key = (wanted, forbidden)
        if key not in held:
            held.clear()  # one site is some megabytes; the last one is enough
            held[key] = prepare_site(scene, model=wanted, grid=grid, forbidden=picker.cells(grid))
        site = held[key]
        if not site.served.any():
            raise ArgumentError("reach: no camera sees anybody square-on; widen it.")
        cameras, choice = choose_cameras(site, method, n, time_limit=PATIENCE)
        seen = judge_cameras(cameras, site.targets, model=wanted, walls=scene.walls)
        plot_ground(scene.area, walls=scene.walls, ax=plan)
        plot_forbidden(grid, site.forbidden, ax=plan)
        plot_served(site.targets, seen, ax=plan)
        plot_cameras(cameras, wanted, method=method, cones=not pans, ax=plan)
        proof = "" if choice is None else f", none sees more than {choice.bound:.3f}"
        return f"seen square-on: <b>{seen.mean():.3f}</b> of {len(seen)} walker-seconds{proof}"

    panel = Panel(
        draw,
        {
            "method": choices("method", ["swaps", "exact", "greedy", "votes", "area"]),
            "n": slider("cameras", 1, 8, 3),
            "pans": choices("camera", [("pans (PTZ)", True), ("fixed", False)], value=model.pans),
            "field_of_view": slider("field of view (°)", 20, 120, round(model.field_of_view)),
            "reach": slider("range (m)", 2, max(30, round(model.reach)), round(model.reach)),
            "square_within": slider("off square-on (°)", 5, 45, round(model.square_within)),
            "forbidden": picker,
        },
        figsize=(8, 4),
    )
    # A camera that pans looks everywhere.
    ipywidgets.dlink(
        (panel.controls["pans"], "value"), (panel.controls["field_of_view"], "disabled")
    )
    return panel
