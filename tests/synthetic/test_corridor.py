"""The synthetic corridor: its best places are true, and so are its walkers."""

import numpy as np
import pytest

from mcnlab.cameras.floor import GridMap
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.corridor import KINDS, Corridor, make_corridor
from mcnlab.tables import FRAME, TRACE, X, Y, check_traces

CORRIDOR = Corridor()


@pytest.fixture(scope="module")
def scene():
    return make_corridor()


def through(scene):
    """Those who go from end to end."""
    return scene.traces[scene.traces[TRACE].str.startswith("through")]


def crosses(start, stop, segments):
    """Whether the segment from start to stop properly crosses any of segments."""

    def side(a, b, c):
        ab, ac = b - a, c - a
        return np.sign(ab[..., 0] * ac[..., 1] - ab[..., 1] * ac[..., 0])

    a, b = segments[:, 0], segments[:, 1]
    across = side(a, b, start) * side(a, b, stop) < 0
    return (across & (side(start, stop, a) * side(start, stop, b) < 0)).any()


# The plan


def test_the_best_places_are_the_middles_of_the_cells_of_the_thesis():
    grid = GridMap.over(CORRIDOR.area, cell=0.5)
    assert grid.shape == (10, 23)
    row, column = grid.cell_of(*CORRIDOR.best_places.T)
    assert list(zip(row, column, strict=True)) == [(4, 4), (5, 18)]
    assert np.stack(grid.place_of(row, column), axis=1) == pytest.approx(CORRIDOR.best_places)


@pytest.mark.parametrize("corridor", [CORRIDOR, CORRIDOR.mirrored()])
def test_the_normals_of_every_bend_meet_in_its_centre(corridor):
    points, normals = corridor.spine
    for centre, side in zip(corridor.best_places, (-1, 1), strict=True):
        # The front is tilted by atan(0.5/7): its tangent point lies 0.4·0.071 m further out.
        bend = (points[:, 0] - centre[0]) * side > 0.029
        assert bend.sum() > 50
        foot = points[bend] - corridor.planter * normals[bend]
        assert foot == pytest.approx(np.broadcast_to(centre, foot.shape), abs=1e-9)


def test_lanes_run_square_to_the_normals():
    points, normals = CORRIDOR.spine
    for radius in CORRIDOR.lanes:
        lane = points + (radius - CORRIDOR.planter) * normals
        step = np.diff(lane, axis=0)
        middle = normals[:-1] + normals[1:]
        # Between two points of an arc the mean normal is square to the chord exactly; where
        # an arc meets a straight line the normals are the same.
        assert np.abs((step * middle).sum(axis=1)).max() < 1e-9
        assert (
            np.linalg.norm(step, axis=1).max() < 0.02 * CORRIDOR.lanes[1] / CORRIDOR.planter + 0.01
        )


def test_a_best_place_sees_its_bend_and_the_other_post():
    points, normals = CORRIDOR.spine
    outer = points + (CORRIDOR.lanes[1] - CORRIDOR.planter) * normals
    for centre, side in zip(CORRIDOR.best_places, (-1, 1), strict=True):
        for place in outer[(outer[:, 0] - centre[0]) * side > 0][::10]:
            assert not crosses(centre, place, CORRIDOR.walls)
    assert not crosses(*CORRIDOR.best_places, CORRIDOR.walls)


def test_the_stairs_hide_one_arm_from_the_other():
    assert crosses(np.array([3.0, 4.0]), np.array([8.5, 4.0]), CORRIDOR.walls)


def test_mirrored_twice_is_the_same():
    twice = CORRIDOR.mirrored().mirrored()
    assert np.array(twice.centres) == pytest.approx(np.array(CORRIDOR.centres))
    assert twice.stairs == pytest.approx(CORRIDOR.stairs)
    assert twice.doors == pytest.approx(CORRIDOR.doors)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"lanes": (0.3, 1.9)}, "planter"),
        ({"lanes": (1.9, 0.6)}, "lanes"),
        ({"lanes": (0.6, np.nan)}, "lanes"),
        ({"lanes": None}, "lanes"),
        ({"planter": np.nan}, "planter"),
        ({"planter": "wide"}, "planter"),
        ({"centres": ((1.0, 2.25), (9.25, 2.75))}, "room"),
        ({"centres": ((np.nan, 2.25), (9.25, 2.75))}, "centres"),
        ({"centres": ((1.0, 2.25),)}, "centres"),
        ({"centres": ((9.25, 2.75), (2.25, 2.25))}, "stairs"),
        ({"stairs": (1.0, 2.8, 7.55)}, "stairs"),
        ({"stairs": (3.95, 1.0, 7.55)}, "stairs"),
        ({"stairs": (3.95, np.nan, 7.55)}, "stairs"),
        ({"area": (0, 0, -1, 5)}, "area"),
        ({"doors": ()}, "doors"),
        ({"doors": (99.0,)}, "doors"),
    ],
)
def test_an_impossible_plan_is_refused(change, word):
    with pytest.raises(ArgumentError, match=word):
        Corridor(**change)


# The walkers


def test_the_walkers_are_a_sound_scene(scene):
    check_traces(scene.traces)
    assert scene.name == "corridor"
    assert scene.source == "synthetic"
    assert len(scene.walkers) == 150
    assert {name.split("-")[0] for name in scene.walkers} == set(KINDS)
    assert scene.walls.tolist() == CORRIDOR.walls.tolist()


def test_everybody_stays_in_the_corridor(scene):
    left, bottom, right, top = CORRIDOR.inside
    x, y = scene.traces[X].to_numpy(), scene.traces[Y].to_numpy()
    assert ((x > left) & (x < right) & (y > bottom) & (y < top)).all()
    # Nearest point of the planter's axis: nobody walks on it, or in the stairs.
    a, b = CORRIDOR.best_places
    share = ((np.stack([x, y], axis=1) - a) @ (b - a) / ((b - a) @ (b - a))).clip(0, 1)
    off = np.hypot(x - a[0] - share * (b - a)[0], y - a[1] - share * (b - a)[1])
    # In the arms the lanes keep to the stairs' doors, not to the planter.
    arm = (x > a[0]) & (x < b[0]) & (y > np.interp(x, *CORRIDOR.best_places.T))
    # A chord of the planned path (2 cm at most, and 4 in the outer lane) dips by no more than
    # a millimetre; a lingerer shifts by up to 12 cm either way along each axis.
    assert off.min() > CORRIDOR.planter
    still = scene.traces[TRACE].str.startswith(("linger", "cross")).to_numpy()
    assert off[~still & ~arm].min() > CORRIDOR.lanes[0] - 0.001
    west, south, east = CORRIDOR.stairs
    assert not ((x > west + 0.13) & (x < east - 0.13) & (y > south)).any()


def test_who_walks_through_walks_square_to_the_bend(scene):
    walks = through(scene)
    step = walks.groupby(TRACE)[[X, Y]].diff()
    known = step[X].notna()
    middle = (walks[[X, Y]] - step[[X, Y]] / 2)[known].to_numpy()
    step = step[known].to_numpy()
    for centre, side in zip(CORRIDOR.best_places, (-1, 1), strict=True):
        bend = (middle[:, 0] - centre[0]) * side > 0.1
        radial = middle[bend] - centre
        cosine = (radial * step[bend]).sum(axis=1)
        cosine /= np.linalg.norm(radial, axis=1) * np.linalg.norm(step[bend], axis=1)
        # Three sines of 4 cm and 2.5 m or longer slope by at most 0.12·2π/2.5 = 0.30 per
        # metre of the planter's edge; a lane's metre is longer by radius/planter > 1.5.
        assert np.abs(cosine).max() < 0.30 / 1.5 + 0.02
        # Sways cancel: the mean is nought, by far less than half an orientation bin (0.196).
        assert abs(cosine.mean()) < 0.02


def test_people_walk_at_a_walking_pace_in_both_senses(scene):
    walks = through(scene)
    groups = walks.groupby(TRACE)
    speed = np.hypot(*groups[[X, Y]].diff().dropna().to_numpy().T) * scene.frame_rate
    # 1.1 to 1.5 m/s along the path, its pace varying by 6 %; chords are hardly shorter.
    assert 1.1 * 0.94 * 0.98 < speed.min() < speed.max() < 1.5 * 1.06 * 1.001
    rightwards = groups[X].agg(lambda x: x.iloc[-1] > x.iloc[0])
    assert 0.3 < rightwards.mean() < 0.7


def test_some_stand_about(scene):
    for kind, least in (("linger", 4), ("cross", 4)):
        walks = scene.traces[scene.traces[TRACE].str.startswith(kind)]
        steps = walks.groupby(TRACE)[[X, Y]].diff()
        slow = np.hypot(steps[X], steps[Y]) * scene.frame_rate < 0.9
        assert (slow.groupby(walks[TRACE]).sum() >= (least - 1) * scene.frame_rate).all()


def test_doors_are_used(scene):
    walks = scene.traces[scene.traces[TRACE].str.startswith("door")]
    ends = walks.groupby(TRACE).agg(["first", "last"])
    at_parapet = np.minimum(ends[Y]["first"], ends[Y]["last"])
    assert (at_parapet < 0.3).all()


def test_the_seed_makes_the_walkers():
    first, again, other = (make_corridor(walkers=5, seed=seed).traces for seed in (3, 3, 4))
    assert first.equals(again)
    assert not first.equals(other)


def test_arrivals_keep_the_rate():
    scene = make_corridor(walkers=400, per_minute=30)
    first = scene.traces.groupby(TRACE)[FRAME].first().max() / scene.frame_rate / 60
    # 400 gaps of mean 2 s: the total's standard deviation is a twentieth.
    assert first == pytest.approx(400 / 30, rel=4 / 20)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"walkers": 0}, "walkers"),
        ({"walkers": 2.5}, "walkers"),
        ({"seed": -1}, "seed"),
        ({"frame_rate": 0}, "frame_rate"),
        ({"frame_rate": np.inf}, "frame_rate"),
        ({"per_minute": 0}, "per_minute"),
        ({"per_minute": np.nan}, "per_minute"),
    ],
)
def test_impossible_walkers_are_refused(options, word):
    with pytest.raises(ArgumentError, match=word):
        make_corridor(**options)
