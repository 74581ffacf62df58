"""View angles: walks filmed at each, how well steps show, and where half the peak is lost."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mcnlab.errors import ArgumentError, TableError
from mcnlab.synthetic.noise import CASIA_LIKE, SegmentationNoise
from mcnlab.vision import recordings
from mcnlab.walking.gait import measure_gait
from mcnlab.walking.viewpoint import (
    detectability,
    half_peak_angle,
    record_at_angles,
    view_angle,
    view_angle_of,
)

RATE = 25.0


@pytest.fixture(scope="module")
def casia():
    """CASIA A without mirrored copies: its gait by step and stride, and its view angles."""
    recording = recordings.casia_a(mirrored=False)
    angles = recording.directions.map(view_angle_of)
    step, stride = (
        measure_gait(recording.boxes, frame_rate=recording.frame_rate, rhythm=rhythm)
        for rhythm in ("step", "stride")
    )
    return step, stride, angles


@given(st.floats(-720, 720))
def test_view_angle_folds_the_heading(heading):
    angle = view_angle(heading)
    # The sine's slope is 0 at square-on: an error of 1e-16 there is one of 1e-6 degrees.
    assert angle == pytest.approx(np.degrees(np.arcsin(abs(np.sin(np.radians(heading))))), abs=1e-5)
    for same in (-heading, heading + 180, 180 - heading):
        assert view_angle(same) == pytest.approx(angle, abs=1e-9)


def test_the_eight_directions_have_three_view_angles():
    assert [view_angle_of(direction) for direction in range(1, 9)] == [0, 45, 90, 45] * 2


def test_walks_at_angles_are_what_they_say():
    angles = [0.0, 30.0, 90.0]
    noises = (None, CASIA_LIKE)
    tables, truth = record_at_angles(angles, subjects=2, seed=3, noises=noises)
    (again,), _ = record_at_angles(angles, subjects=2, seed=3, noises=noises[1:])
    assert again.equals(tables[1])
    assert not tables[0].equals(tables[1])
    assert view_angle(truth["heading"]) == pytest.approx(truth["angle"].to_numpy())
    assert truth.groupby("angle").size().tolist() == [4, 4, 4]
    assert list(tables[0]["sequence"].unique()) == list(truth.index)
    # One camera, 2.5 s a walk at the most.
    assert tables[0].groupby("sequence").size().max() <= 60


def test_detectability_rises_with_the_view_angle():
    (clean, noisy), truth = record_at_angles(
        [15, 30, 45, 60, 90], subjects=4, seed=1, noises=(None, CASIA_LIKE)
    )
    for boxes in (clean, noisy):
        found = measure_gait(boxes, frame_rate=RATE)
        table = detectability(found, truth["angle"], steps=truth["step_s"])
        assert (table["walks"] == 8).all()
        # From 45° on every step period is found, and right; the peak rises to square-on.
        late = table[table["angle"] >= 45]
        assert (late["right"] >= 7).all()
        assert late["peak"].is_monotonic_increasing
        # Between 10° and 30° a left step does not look like a right one: no step, but a
        # stride.
        early = table[table["angle"].isin([15, 30])]
        assert (early["right"] <= 2).all()
        assert 30 < half_peak_angle(table) < 45
        # Strides differ where steps do not show.
        stride = measure_gait(boxes, frame_rate=RATE, rhythm="stride")
        strides = detectability(stride, truth["angle"], steps=truth["step_s"])
        assert strides.loc[strides["angle"] == 15, "right"].item() >= 6
        assert strides.loc[strides["angle"] == 90, "detected"].item() <= 2
        # The width swings with the sine of the angle, more or less.
        assert table["swing"].is_monotonic_increasing


def test_on_casia_steps_show_square_on_and_not_in_front(casia):
    step, _, angles = casia
    table = detectability(step, angles).set_index("angle")
    assert table["walks"].tolist() == [56, 56, 56]
    assert table.loc[90, "detected"] == 56
    assert table.loc[45, "detected"] >= 52
    # In front no more than noise: the binomial's 0.1 % tail of 5 % is 8 of 56.
    assert table.loc[0, "detected"] <= stats.binom.ppf(0.999, 56, 0.05)
    assert table.loc[90, "peak"] > 0.9 > table.loc[45, "peak"] > 0.4
    assert table.loc[0, "peak"] < 0.1
    # Two steps a second, as adults walk (101 … 122 steps a minute: Perry and Burnfield).
    assert 60 / 122 < table.loc[90, "step_s"] < 60 / 101
    assert table.loc[45, "step_s"] == pytest.approx(table.loc[90, "step_s"], rel=0.05)


def test_on_casia_a_frontal_walk_still_shows_its_stride(casia):
    _, stride, angles = casia
    table = detectability(stride, angles).set_index("angle")
    # More than chance: the binomial's 99.9 % quantile at 5 % is 8 of 56.
    assert table.loc[0, "detected"] > stats.binom.ppf(0.999, 56, 0.05)
    assert table.loc[90, "detected"] <= stats.binom.ppf(0.999, 56, 0.05)


def test_detectability_counts_by_hand():
    found = pd.DataFrame(
        {
            "step_s": [0.5, 0.6, 0.0],
            "peak": [0.9, 0.7, 0.1],
            "detectable": [True, True, False],
            "swing": [0.2, 0.1, 0.0],
        },
        index=["a", "b", "c"],
    )
    angles = pd.Series({"a": 90, "b": 90, "c": 0, "never measured": 0})
    steps = pd.Series({"a": 0.52, "b": 0.5, "c": 0.5, "never measured": 0.5})
    table = detectability(found, angles, steps=steps)
    assert table["angle"].tolist() == [0, 90]
    assert table["walks"].tolist() == [2, 2]
    assert table["detected"].tolist() == [0, 2]
    assert table["right"].tolist() == [0, 1]  # 0.6 is off by a fifth
    assert table["right_share"].tolist() == [0, 0.5]
    assert table["peak"].tolist() == pytest.approx([0.05, 0.8])
    assert table["peak_low"].tolist() == pytest.approx([0.025, 0.75])
    assert detectability(found, angles)["step_s"].tolist() == pytest.approx([0, 0.55])


def test_half_the_peak_is_lost_between_two_angles():
    table = pd.DataFrame({"angle": [90, 0, 30, 60], "peak": [0.8, 0.1, 0.2, 0.6]})
    assert half_peak_angle(table) == pytest.approx(45)  # 0.4 is midway from 0.2 to 0.6
    # A frontal peak that comes back does not count: from square-on on, the first loss.
    table = pd.DataFrame({"angle": [0, 10, 20, 90], "peak": [0.9, 0.1, 0.5, 1.0]})
    assert half_peak_angle(table) == pytest.approx(20)


def test_a_peak_that_is_never_lost_is_refused():
    table = pd.DataFrame({"angle": [45, 90], "peak": [0.6, 0.8]})
    with pytest.raises(ArgumentError, match="nearer to frontal"):
        half_peak_angle(table)
    with pytest.raises(ArgumentError, match="nearer to frontal"):
        half_peak_angle(table.iloc[:0])


@pytest.mark.parametrize("name", ["angle", "peak"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("row", range(4))
def test_a_peak_or_an_angle_that_is_not_finite_is_refused(name, value, row):
    table = pd.DataFrame({"angle": [0.0, 30.0, 60.0, 90.0], "peak": [0.1, 0.2, 0.6, 0.8]})
    table.loc[row, name] = value
    with pytest.raises(TableError, match=f"table's {name} is .* in row {row}; .*finite"):
        half_peak_angle(table)
    with pytest.raises(TableError, match=f"table's {name} holds what is no number"):
        half_peak_angle(table.assign(**{name: "wide"}))


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"angles": []}, "angles"),
        ({"angles": [0, 0]}, "angles"),
        ({"angles": [91]}, "angles"),
        ({"angles": [np.nan]}, "angles"),
        ({"subjects": 0}, "subjects"),
        ({"seed": -1}, "seed"),
        ({"angles": 45}, "angles has the shape"),
        ({"noises": ()}, "noises"),
        ({"noises": None}, "list"),
        ({"view": "from above"}, "view"),
        ({"noises": ("much",)}, "noise"),
        ({"noises": (SegmentationNoise(missing=1.0),)}, "hides every walker"),
        ({"distance": 0}, "distance"),
        ({"n_frames": 1}, "max_frames"),
    ],
)
def test_walks_that_cannot_be_filmed_are_refused(options, word):
    options = {"angles": [90], "subjects": 1, **options}
    with pytest.raises(ArgumentError, match=word):
        record_at_angles(options.pop("angles"), **options)


@pytest.mark.parametrize("heading", [np.nan, [0, np.inf], "north", None])
def test_a_heading_that_is_no_angle_is_refused(heading):
    with pytest.raises(ArgumentError, match="heading"):
        view_angle(heading)


@pytest.mark.parametrize("direction", [0, 9, "away", None, [1, 2]])
def test_a_direction_that_is_none_of_the_eight_is_refused(direction):
    with pytest.raises(ArgumentError, match="direction"):
        view_angle_of(direction)


def test_unsound_tables_are_refused(make_boxes):
    found = measure_gait(make_boxes(60), frame_rate=RATE)
    with pytest.raises(TableError, match="lacks sequence"):
        detectability(found, pd.Series({"other": 0.0}))
    with pytest.raises(TableError, match="steps lacks"):
        detectability(found, pd.Series({"walk": 0.0}), steps=pd.Series({"other": 0.5}))
    for angles, word in (([0.0], "Series"), (pd.Series({"walk": 91.0}), "angles is")):
        with pytest.raises(ArgumentError, match=word):
            detectability(found, angles)
    with pytest.raises(TableError, match="twice"):
        detectability(pd.concat([found, found]), pd.Series({"walk": 0.0}))
    with pytest.raises(TableError, match="lacks the column"):
        detectability(found.drop(columns="peak"), pd.Series({"walk": 0.0}))
