"""The panels of walking say what is measured and judged."""

import re

import numpy as np
import pytest

from mcnlab import widgets
from mcnlab.statistics import median_by_subject
from mcnlab.walking import direction, evaluation, gait, heading, outdoors, phase, speed, viewpoint
from mcnlab.widgets.walking import _overlap


def moved_to(panel, **values):
    """A panel after its controls were moved."""
    for name, value in values.items():
        panel.controls[name].value = value
    return panel


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
    assert "100%" in moved_to(panel, specks=0, holes=0, limbs=0, min_area=1).text.value
    few = casia.with_boxes(
        casia.boxes[casia.boxes["sequence"] == casia.sequences[0]].head(10).reset_index(drop=True),
        directions=casia.directions[casia.sequences[:1]],
        copies=frozenset(),
    )
    assert "ArgumentError" in widgets.heading_panel(few, focal_length=450).text.value


def test_mirror_panel_offers_the_oblique_walks(casia):
    panel = widgets.mirror_panel(casia)
    offered = panel.controls["sequence"].options
    assert set(direction.group_of(casia.directions[list(offered)])) == {2, 4}
    name = panel.controls["sequence"].value
    assert f"in direction {casia.directions[name]}" in panel.text.value


def test_overlap_is_intersection_over_union(masks):
    from mcnlab.vision.silhouettes import find_body

    body = find_body(masks[0])
    assert _overlap(body, body) == 1
    far = np.roll(masks[0], 120, axis=1)
    assert _overlap(body, find_body(far)) == 0


def test_the_gait_panel_says_the_rhythm_it_shows(new_panel, angled):
    boxes, truth = angled
    panel = new_panel("gait")
    assert panel.controls["angle"].options == (0, 90)
    for subject in ("s01", "s02"):
        moved_to(panel, subject=subject, angle=90)
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


@pytest.fixture(scope="module")
def tables():
    """Title → all windows of a place, from the bundled tables."""
    return {title: outdoors.apparent_speeds(title) for title in ("pets", "tud")}


@pytest.fixture(scope="module")
def seconds(tables):
    """Title → the one-second windows with their levels."""
    held = {title: table[table["seconds"] == 1] for title, table in tables.items()}
    return {
        title: table.assign(level=speed.level_of(table["share"], frame_width=1))
        for title, table in held.items()
    }


def test_the_speed_panel_follows_its_thresholds(tables):
    panel = widgets.speed_panel(tables)
    pictures = set()
    for name, value in (("slow", 3.0), ("fast", 7.0), ("seconds", 2.0), ("where", "tud")):
        panel.controls[name].value = value
        pictures.add(bytes(panel.picture.value))
    assert len(pictures) == 4
    assert all(picture.startswith(b"\x89PNG") for picture in pictures)


def test_the_speed_panel_says_what_is_reported(tables, seconds):
    panel = widgets.speed_panel(tables)
    table = seconds["pets"]
    said = [float(value) for value in re.findall(r"<b>([\d.]+) m/s</b>", panel.text.value)]
    for level, value in zip(speed.LEVELS, said, strict=True):
        own = table[table["level"] == level]
        held = median_by_subject(own["true_speed"], own["sequence"], draws=1)
        assert value == round(held.value, 2)
    wrong = speed.misordered(table["true_speed"], table["level"], table["sequence"], draws=1)
    assert f"<b>{wrong.value:.0%}</b>" in panel.text.value


def test_the_speed_panel_says_when_a_level_is_empty_or_impossible(tables):
    panel = widgets.speed_panel(tables)
    panel.controls["slow"].value = 0.0
    panel.controls["fast"].value = 20.0
    assert "v3 <b>no window</b>" in panel.text.value
    assert "truly faster" not in panel.text.value
    panel.controls["slow"].value = 10.0
    panel.controls["fast"].value = 2.0
    assert "fast is 0.02, below slow, 0.1" in panel.text.value
