"""The panels of chapter 2: from a video seen from above to camera places."""

import ipywidgets
import numpy as np

from mcnlab import cells, flow, gait, placement, plotting, siting
from mcnlab.columns import SEQUENCE, W, X, Y
from mcnlab.coverage import CameraModel
from mcnlab.errors import ArgumentError
from mcnlab.figures.voting import draw_cells
from mcnlab.ground import GridMap
from mcnlab.widgets.panel import CellPicker, Panel, choices, decimal_slider, label, slider

PATIENCE = 2.0  # s; a proof that takes longer is cut short, and the bound says so


def gait_panel(boxes, truth, *, frame_rate):
    """Turn a synthetic walker and watch his box's width and its rhythm.

    Parameters
    ----------
    boxes : pandas.DataFrame
        From `viewpoint.record_at_angles`.
    truth : pandas.DataFrame
        Its walks: ``subject, angle, step_s``.
    frame_rate : float
    """
    walks = dict(list(boxes.groupby(SEQUENCE, sort=False)))
    truth = truth.loc[list(walks)]
    angles = sorted(truth["angle"].unique())

    def draw(left, right, subject, angle):
        at = min(angles, key=lambda held: abs(held - angle))
        there = truth.index[(truth["angle"] == at) & (truth["subject"] == subject)]
        if len(there) == 0:
            raise ArgumentError(f"angle: {subject} has no walk at {at:g}°; pick another.")
        name = there[0]
        walk = walks[name]
        seconds = (walk["frame"] - walk["frame"].iloc[0]) / frame_rate
        plotting.plot_width(seconds, walk[W], colour=plotting.METHOD_COLOURS["growth"], ax=left)
        left.set_ylim(0, 1.05 * boxes[W].max())
        lags, correlation, period = gait.rhythm_of(walk, frame_rate=frame_rate)
        right.plot(lags, correlation, color=plotting.METHOD_COLOURS["growth"])
        if period.step > 0:
            right.plot(period.step, period.peak, "o", color=plotting.UPPER)
        right.set(xlim=(0, 1.6), ylim=(-1, 1), xlabel="lag (s)", ylabel="autocorrelation")
        found = f"step <b>{period.step:.2f} s</b>" if period.detectable else "<b>no rhythm</b>"
        return (
            f"σ = {at:g}°: {found} (true step {truth.step_s[name]:.2f} s), "
            f"autocorrelation {period.peak:.2f}, p = {period.p_value:.3f}"
        )

    return Panel(
        draw,
        {
            "subject": ipywidgets.Dropdown(
                options=sorted(truth["subject"].unique()), **label("walker", width="500px")
            ),
            "angle": ipywidgets.SelectionSlider(
                options=[int(held) for held in angles],
                value=int(min(angles, key=lambda held: abs(held - 60))),
                **label("view angle (°)", width="500px"),
            ),
        },
        columns=2,
        margins={"wspace": 0.35},
    )


def flow_panel(frames):
    """Horn and Schunck's weight, iterations and the speed threshold, on two frames.

    Parameters
    ----------
    frames : (ndarray, ndarray)
        Two grey frames of one size, one after the other.
    """
    first, second = frames
    wheel = flow.colour_legend(48)

    def draw(left, right, alpha, iterations, speed, pyramid):
        if pyramid:
            motion = flow.horn_schunck(first, second, alpha=alpha, iterations=iterations)
        else:
            motion = flow.horn_schunck_plain(first, second, alpha=alpha, iterations=iterations)
        mask = flow.moving_mask(motion, speed=speed)
        colours = flow.colour_flow(motion, largest=3.0)
        plotting.plot_flow(colours, wheel, largest=3.0, ax=left)
        plotting.plot_frame(255 - mask, ax=right)
        return f"moving: <b>{np.mean(mask > 0):.1%}</b> of the pixels"

    return Panel(
        draw,
        {
            "alpha": decimal_slider("weight α (grey levels)", 1, 40, flow.ALPHA, step=1),
            "iterations": slider("iterations", 5, 200, 20, step=5),
            "speed": decimal_slider("speed (px a frame)", 0.1, 3, 0.5, step=0.1),
            "pyramid": choices("flow", [("pyramid", True), ("one level, as in 1981", False)]),
        },
        columns=2,
        figsize=(8, 2.9),
        margins={"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.98, "wspace": 0.04},
    )


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
        placed = placement.place_by_votes(
            scene.traces,
            grid,
            n=n,
            chaos_ratio=chaos_ratio,
            least_traces=least_traces,
            forbidden=barred | siting.no_floor(scene, grid),
            angles=angles,
        )
        plotting.plot_mesh(grid, placed.votes, most=24, ax=mesh)
        plotting.plot_ground(grid.area, walls=scene.walls, ax=plan)
        draw_cells(grid, placed.cells, ax=plan)
        plotting.plot_forbidden(grid, barred, ax=plan)
        plan.plot(placed.places[X], placed.places[Y], "^", ms=11, color=plotting.UPPER, mec="white")
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
    grid = siting.grid_over(scene.area)
    held = {}

    def draw(plan, method, n, pans, field_of_view, reach, square_within, forbidden):
        wanted = CameraModel(field_of_view, min(model.near, reach / 2), reach, pans, square_within)
        key = (wanted, forbidden)
        if key not in held:
            held.clear()  # one site is some megabytes; the last one is enough
            held[key] = siting.prepare_site(
                scene, model=wanted, grid=grid, forbidden=picker.cells(grid)
            )
        site = held[key]
        if not site.served.any():
            raise ArgumentError("reach: no camera sees anybody square-on; widen it.")
        cameras, choice = siting.choose_cameras(site, method, n, time_limit=PATIENCE)
        seen = siting.judge_cameras(cameras, site.targets, model=wanted, walls=scene.walls)
        plotting.plot_ground(scene.area, walls=scene.walls, ax=plan)
        plotting.plot_forbidden(grid, site.forbidden, ax=plan)
        plotting.plot_served(site.targets, seen, ax=plan)
        plotting.plot_cameras(cameras, wanted, method=method, cones=not pans, ax=plan)
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
