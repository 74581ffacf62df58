"""The panels of chapter 2: from a video seen from above to camera places."""

from functools import cache, lru_cache

import ipywidgets
import numpy as np

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.figures.placement import draw_cells
from mcnlab.placement import cells, votes
from mcnlab.placement.site import choose_cameras, grid_over, judge_cameras, no_floor, prepare_site
from mcnlab.plotting import placement as plots
from mcnlab.plotting.style import UPPER
from mcnlab.tables import X, Y
from mcnlab.widgets.panel import CellPicker, Panel, choices, decimal_slider, slider

PATIENCE = 2.0  # s; a proof that takes longer is cut short, and the bound says so


def vote_panel(scene: Scene) -> Panel:
    """Cell size, chaos rule, cameras and forbidden cells; the mesh and the plan follow.

    Parameters
    ----------
    scene : Scene

    Examples
    --------
    >>> from mcnlab.synthetic import make_corridor
    >>> panel = vote_panel(make_corridor(walkers=30, seed=1))
    >>> panel.controls["n"].value
    2
    """
    picker = CellPicker(scene.area)

    @cache
    def angles_by(cell):
        grid = GridMap.over(scene.area, cell=cell)
        return grid, cells.orientations(scene.traces, grid)

    def draw(mesh, plan, cell, n, forbidden, **rules):
        grid, angles = angles_by(cell)
        barred = picker.cells(grid)
        placed = votes.place_by_votes(
            scene.traces,
            grid,
            n=n,
            rules=votes.VoteRules(**rules),
            forbidden=barred | no_floor(scene, grid),
            angles=angles,
        )
        plots.plot_mesh(grid, placed.votes, most=24, ax=mesh)
        plots.plot_ground(grid.area, walls=scene.walls, ax=plan)
        draw_cells(grid, placed.cells, ax=plan)
        plots.plot_forbidden(grid, barred, ax=plan)
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


def choice_panel(scene: Scene, *, model: CameraModel) -> Panel:
    """Number of cameras, what each can see, and where none may stand; the plan follows.

    Parameters
    ----------
    scene : Scene
    model : cameras.CameraModel
        To begin with.

    Examples
    --------
    >>> from mcnlab.cameras import CameraModel
    >>> from mcnlab.synthetic import make_corridor
    >>> panel = choice_panel(make_corridor(walkers=5), model=CameraModel(pans=True))
    >>> panel.controls["field_of_view"].disabled  # a camera that pans looks everywhere
    True
    """
    picker = CellPicker(scene.area)
    grid = grid_over(scene.area)

    # One site is some megabytes; the last one is enough.
    @lru_cache(maxsize=1)
    def site_for(wanted, _forbidden):
        return prepare_site(scene, model=wanted, grid=grid, forbidden=picker.cells(grid))

    def draw(plan, method, n, pans, field_of_view, reach, square_within, forbidden):
        wanted = CameraModel(field_of_view, min(model.near, reach / 2), reach, pans, square_within)
        site = site_for(wanted, forbidden)
        if not site.served.any():
            raise ArgumentError("reach: no camera sees anybody square-on; widen it.")
        cameras, choice = choose_cameras(site, method, n, time_limit=PATIENCE)
        seen = judge_cameras(cameras, site.targets, model=wanted, walls=scene.walls)
        plots.plot_ground(scene.area, walls=scene.walls, ax=plan)
        plots.plot_forbidden(grid, site.forbidden, ax=plan)
        plots.plot_served(site.targets, seen, ax=plan)
        plots.plot_cameras(cameras, wanted, method=method, cones=not pans, ax=plan)
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
