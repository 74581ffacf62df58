"""The panels of placement say what the votes say and what the cameras see."""

import numpy as np
import pytest

from mcnlab import widgets
from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.placement import votes
from mcnlab.placement.site import choose_cameras, judge_cameras, prepare_site


def moved_to(panel, **values):
    """A panel after its controls were moved."""
    for name, value in values.items():
        panel.controls[name].value = value
    return panel


def test_the_vote_panel_draws_its_mesh_in_space(new_panel):
    panel = new_panel("vote")
    mesh, plan = panel._axes
    assert (mesh.name, plan.name) == ("3d", "rectilinear")
    heights = []
    for cell in (0.3, 2.0, 0.5):
        moved_to(panel, cell=cell)
        heights.append(mesh.zz_dataLim.intervalx[1])
        assert panel.text.value.endswith(f"most votes in one cell: {heights[-1]:g}")
    assert heights[0] > heights[2] > heights[1]  # no height is left from the move before
    assert panel._axes == [mesh, plan]


def test_the_vote_panel_says_what_the_votes_say(new_panel, corridor):
    panel = moved_to(new_panel("vote"), cell=0.8, n=1, forbidden=((4, 3), (5, 3)))
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
    panel = moved_to(new_panel("choice"), method=method, n=2, reach=3)
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
    moved_to(panel, n=8, cell=2.0, forbidden=most)
    assert panel.text.value.startswith("<b>ArgumentError</b>: n is 8")
    moved_to(panel, n=1, forbidden=every_block(panel))
    assert panel.text.value.startswith("<b>ArgumentError</b>: forbidden and votes leave no place")
    assert "humps" in moved_to(panel, forbidden=()).text.value
    panel = new_panel("choice")
    moved_to(panel, forbidden=every_block(panel))
    assert "leaves no place for a camera" in panel.text.value
    assert "seen square-on" in moved_to(panel, forbidden=()).text.value
    assert bytes(panel.picture.value).startswith(b"\x89PNG")
