"""The figures of heading are tested by what is drawn on them."""

import numpy as np

from mcnlab.figures.registry import draw
from mcnlab.walking import evaluation, heading


def test_heading_errors_are_drawn_at_their_direction(casia):
    headings = heading.measure_headings(casia, focal_length=450)
    _, _, errors = evaluation.judge_headings(casia, headings)
    ax = draw("heading", casia, {"whole walks": (headings, errors)}).axes[0]
    truth = evaluation.truth_of(casia, headings["sequence"])
    dots = [line for line in ax.lines if line.get_linestyle() == "None"]
    for way, line in zip(range(1, 9), dots, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), np.sort(errors[truth == way]))
        assert np.abs(np.asarray(line.get_xdata()) - way).max() < 0.5
