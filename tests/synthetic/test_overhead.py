"""The corridor's video shows what its truth says."""

import cv2
import numpy as np
import pytest

from mcnlab.cameras.homography import find_homography, project
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.corridor import Corridor, make_corridor
from mcnlab.synthetic.overhead import TOP_FLOOR, render_corridor, render_frames
from mcnlab.tables import FRAME, TRACE, X, Y, check_traces

CORRIDOR = Corridor()


@pytest.fixture(scope="module")
def scene():
    return make_corridor()


@pytest.fixture(scope="module")
def video():
    return render_corridor(walkers=12, seconds=30, noise=0)


@pytest.fixture(scope="module")
def empty(scene):
    """The corridor after the last walker has left."""
    stop = int(scene.traces[FRAME].max()) + 2
    return next(render_frames(scene, start=stop - 1, stop=stop, noise=0)).astype(float)


# The camera


def test_the_whole_corridor_is_in_view():
    left, bottom, right, top = CORRIDOR.inside
    _, visible = TOP_FLOOR.see([[left, bottom], [right, bottom], [right, top], [left, top]])
    assert visible.all()


# The video


def test_the_video_holds_what_it_says(video):
    assert video.frames.shape == (300, 216, 384)
    assert video.frames.dtype == np.uint8
    check_traces(video.feet)
    assert video.feet[[TRACE, FRAME]].equals(video.truth.traces[[TRACE, FRAME]])
    assert video.truth.traces[FRAME].between(0, 299).all()


def test_true_feet_go_through_the_homography_to_the_ground(video):
    ground = project(video.homography, video.feet[[X, Y]].to_numpy())
    assert ground == pytest.approx(video.truth.traces[[X, Y]].to_numpy(), abs=1e-9)


def test_the_painted_crosses_give_the_homography_within_their_rounding(video):
    assert len(video.image_points) == 6
    measured = find_homography(video.image_points, video.ground_points)
    ground = video.truth.traces[[X, Y]].to_numpy()
    off = np.linalg.norm(project(measured, video.feet[[X, Y]].to_numpy()) - ground, axis=1)
    # Read off to whole pixels, half a pixel's error each way: 0.7 pixels of at most 4 cm on
    # the ground; between the crosses the map errs by little more than they do.
    assert off.max() < 2 * 0.71 * 0.04


def test_the_crosses_are_where_the_table_says(video, empty):
    for x, y in video.image_points.astype(int):
        here = empty[y - 6 : y + 7, x - 6 : x + 7]
        rows, columns = np.nonzero(here > 215)
        # The cross's own centre, read off the image: the pixel and its rounding.
        assert np.abs([columns.mean() - 6, rows.mean() - 6]).max() < 1.0


def test_who_is_drawn_stands_where_the_truth_says(video, empty):
    """Each walker alone in a frame changes the pixels from its feet up to its head."""
    alone = video.feet.groupby(FRAME).filter(lambda rows: len(rows) == 1)
    alone = alone[~alone["hidden"]].iloc[::7]
    assert len(alone) >= 5
    for _, row in alone.iterrows():
        changed = (np.abs(video.frames[int(row[FRAME])] - empty) > 25).astype(np.uint8)
        changed = cv2.morphologyEx(changed, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
        rows, columns = np.nonzero(changed)
        foot = project(TOP_FLOOR.homography, [[row[X], row[Y]]])
        head = TOP_FLOOR.project(np.append(foot[0], 1.66)[None])[0]
        # Ankles swing 0.28·1.07 m about the feet and end in a round 7 cm wide, at up to 37
        # pixels a metre: 13 pixels; a stature differs by 7 % of 1.75 m, 0.5 of it seen: 3.
        assert abs(rows.max() - row[Y]) <= 13
        assert abs(rows.min() - head[1]) <= 3 + 5
        assert abs(columns.mean() - (row[X] + head[0]) / 2) <= 13


def test_stairs_hide_feet():
    west, _, east = CORRIDOR.stairs
    everyone = render_corridor(walkers=30, seconds=60).feet
    x, y = project(TOP_FLOOR.homography, everyone[[X, Y]].to_numpy()).T
    at_stairs = (y > 3.5) & ((np.abs(x - west) < 0.2) | (np.abs(x - east) < 0.2))
    assert everyone["hidden"][at_stairs].mean() > 0.8
    assert not everyone["hidden"][(y > 0.5) & (y < 2.0)].any()
    assert everyone["hidden"].mean() < 0.1


def test_the_video_is_repeatable_and_noise_is_noise():
    quiet, again, noisy, other = (
        render_corridor(walkers=2, seconds=2, **options).frames
        for options in ({"noise": 0}, {"noise": 0}, {"noise": 3}, {"noise": 3, "seed": 1})
    )
    assert (quiet == again).all()
    difference = noisy.astype(float) - quiet
    # 1.6 million pixels; rounding adds a twelfth of a grey level squared twice.
    assert difference.std() == pytest.approx(np.sqrt(9 + 2 / 12), rel=0.02)
    assert not np.array_equal(noisy[0], other[0])


def test_a_part_of_the_video_is_the_same_as_in_the_whole():
    scene = make_corridor(walkers=3)
    whole = list(render_frames(scene, stop=60, noise=0))
    part = list(render_frames(scene, start=40, stop=60, noise=0))
    assert all((a == b).all() for a, b in zip(whole[40:], part, strict=True))


def test_a_video_of_no_frames_is_refused():
    with pytest.raises(ArgumentError, match="stop"):
        next(render_frames(make_corridor(walkers=1), start=5, stop=5))


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"seconds": 0}, "seconds"),
        ({"seconds": np.nan}, "seconds"),
        ({"start": -1}, "start"),
        ({"start": 1e6}, "nobody is there"),
        ({"noise": -1}, "noise"),
        ({"noise": np.inf}, "noise"),
        ({"walkers": 0}, "walkers"),
    ],
)
def test_an_impossible_video_is_refused(options, word):
    with pytest.raises(ArgumentError, match=word):
        render_corridor(**{"walkers": 2, "seconds": 2, **options})
