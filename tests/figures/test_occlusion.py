"""The occlusion figures show what was judged."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Rectangle

from mcnlab.figures.occlusion import draw_case
from mcnlab.figures.registry import draw
from mcnlab.occlusion import composites, thesis, thesis_check
from mcnlab.occlusion.composites import compose
from mcnlab.synthetic.street import make_street
from mcnlab.vision import recordings


@pytest.fixture(scope="module")
def sources():
    """Composites of CASIA A, from the bundled table, and of the made street."""
    casia = composites.compose_all(recordings.casia_a(), focal_length=450, shifts=[0])
    street = composites.compose_all(make_street().recording, focal_length=450, shifts=[0])
    return [casia, street]


@pytest.fixture(scope="module")
def judged(sources):
    """The six cases."""
    return thesis_check.judge_cases(sources)


def written(ax):
    """What is written on axes, legend included."""
    legend = [text.get_text() for text in ax.get_legend().get_texts()] if ax.get_legend() else []
    return [text.get_text() for text in ax.texts] + legend


@pytest.mark.parametrize("number", ["table-3.1", "table-3.2", "table-3.3"])
def test_the_tables_are_drawn_cell_by_cell(number):
    (ax,) = draw(number).axes
    said = written(ax)
    if number == "table-3.1":
        table = thesis.direction_table()
        for code, name in {0: "0", 1: "1", 2: "P(O|S)"}.items():
            headings = 1 if name == "1" else 0  # the column of direction 1
            assert said.count(name) - headings == (table == code).sum()
    else:
        side = "right" if number == "table-3.2" else "left"
        assert said.count("C") == thesis.speed_table(side).sum() == 3
        assert said.count("0") == 6


@pytest.mark.parametrize("number", ["3.14", "3.15"])
def test_each_case_is_a_strip_of_three_frames(judged, sources, number):
    own = judged[judged["figure"].str.startswith(number)].to_dict("records")
    axes = np.reshape(draw(number, judged, sources).axes, (-1, 3))
    assert len(axes) == len(own)
    for row, (start, decision, end) in zip(own, axes, strict=True):
        assert start.get_title(loc="left") == f"{row['figure']}  {row['data']}, frame 1"
        assert decision.get_title(loc="left") == f"frame {row['frame']}: the decision"
        labels = [f"S{who}  D{row[f'direction{who}']}  V{row[f'level{who}']}" for who in (1, 2)]
        assert [text for text in written(decision) if text.startswith("S")] == labels
        happens = row["occludes"]
        later = round((row["seconds"] if happens else row["left"]) * 25)
        ending = "it happens" if happens else "the video ends"
        assert end.get_title(loc="left") == f"frame {row['frame'] + later}: {ending}"
        said = f"in {row['said_seconds']:.1f} s" if row["said"] else "no occlusion"
        assert any("foreseen" in text and said in text for text in written(decision))
        assert any("observed" in text for text in written(end)) == happens


def test_boxes_are_drawn_where_the_walkers_are(judged, sources):
    for row in judged.to_dict("records"):
        recording = sources[row["source"]].recording
        axes = plt.subplots(1, 3)[1]
        draw_case(row, recording, axes)
        both = compose(recording, row["first"], row["second"], shift=row["shift"])
        drawn = {
            (patch.get_x() + 0.5, patch.get_y() + 0.5, patch.get_width(), patch.get_height())
            for patch in axes[0].patches
            if isinstance(patch, Rectangle)
        }
        for name in both.sequences:
            box = both.sequence(name).iloc[0]
            assert (box["x"], box["y"], box["w"], box["h"]) in drawn
        # Everything that is drawn of them lies in the part that is shown.
        left, right = axes[1].get_xlim()
        assert left <= row["x1"] < row["x2"] <= right
        assert right - left <= recording.frame_width


def test_silhouettes_are_painted_where_there_are_any(judged, sources):
    painted = {}
    for row in judged.to_dict("records"):
        axes = plt.subplots(1, 3)[1]
        draw_case(row, sources[row["source"]].recording, axes)
        painted[row["figure"]] = [len(ax.images) for ax in axes]
        for ax in axes:
            for image in ax.images:
                codes = np.unique(image.get_array())
                assert {0, 1, 2} <= set(codes.tolist())
    assert painted["3.14(a)"] == [0, 0, 0]  # without CASIA A's images
    assert painted["3.15(c)"] == painted["3.15(d)"] == [1, 1, 1]


def test_the_cell_shares_are_written_in_the_cells(sources):
    counts = thesis_check.count_cells(sources[0])
    left, right = draw("table-errors", counts).axes
    shown = np.reshape(written(left), (64, 2))[:, 0]
    wrong = np.reshape(written(right), (64, 2))[:, 0]
    corner = np.reshape(written(left), (64, 2))[:, 1]
    for cell, share, miss, code in zip(counts.itertuples(), shown, wrong, corner, strict=True):
        assert code == {0: "0", 1: "1", 2: "P"}[cell.printed]
        if cell.n == 0:
            assert share == miss == "–"
        else:
            assert int(share) == round(100 * cell.occluded / cell.n)
            assert int(miss) == round(100 * (cell.n - cell.right) / cell.n)
