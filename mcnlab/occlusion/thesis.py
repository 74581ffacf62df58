"""Will two walkers cover each other?  The thesis's tables and equations (sections 3.3, 3.5).

S1 is the walker with the lesser abscissa (Algorithm 1).  A first table over both directions
says never, certainly, or "by speed" (Table 3.1); a second one over both speed levels settles
the last (Tables 3.2, 3.3); Equations 3.1 to 3.6 say when and where.

The tables are made here from the rules of section 3.3.1.  As printed, the three rules cut the
64 cells cleanly: "approaching" less its exception holds 21 of them, "departing" 25, "the same
way" 18, no cell is in two and none is left over.  The exception carries this: without it the
four cells with both directions in {1, 5} would be approaching and departing at once, and
departing wins.

What the thesis leaves open, and what is done here:

- Algorithm 1 never sets S2 (misprint 4): S2 is the other walker.  Walkers with the same abscissa
  are "no different subjects" even when one is above the other: the rule is `UNIDENTIFIED`.
- A 0 in Tables 3.2 and 3.3 is explained as speeds too alike, but in half of them the one ahead
  is a good deal faster.  Levels alike are 0 however different the speeds within one level.
- "Equations 4.5 and 4.6" are 3.5 and 3.6 (misprint 4).
- Equations 3.2 to 3.4 are three for two unknowns (misprint 5): see `inconsistency`.  They follow
  S1's motion only, so the mirror image of a scene, where S1 and S2 swap, gets another place;
  and the slope form fails on vertical motion.  See `place_printed` and `place_reached`.
- For walkers going the same way "the same distance equations" must mean D = p·t with that t.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import require_array, require_choice, require_number
from mcnlab.compass import DIRECTIONS
from mcnlab.errors import ArgumentError
from mcnlab.tables import PIXEL_LIMIT
from mcnlab.walking.speed import FAST, LEVELS, SLOW, level_of

APART: Final = 0  # no occlusion: 0 in the tables
CERTAIN: Final = 1  # occlusion: 1 in Table 3.1
BY_SPEED: Final = 2  # P(O|S) in Table 3.1, C in Tables 3.2 and 3.3: time and place decide
UNIDENTIFIED: Final = -1  # the same abscissa: neither is S1
SIDES: Final = {"right": (2, 3, 4), "left": (6, 7, 8)}  # directions across the frame
STILL: Final = 1e-6  # pixels a second; closing in by less is never meeting
STEEPEST: Final = 1e9  # a slope from here on is vertical


class Walker(NamedTuple):
    """Walkers as the camera sees them now: arrays of one shape, one element a pair."""

    x: np.ndarray  # centroid, pixels
    y: np.ndarray
    direction: np.ndarray  # 1 … 8
    pixels: np.ndarray  # the thesis's p: pixels travelled in one second
    vx: np.ndarray  # the way the centroid moves in the image; only its direction counts
    vy: np.ndarray  # downwards


class Foreseen(NamedTuple):
    """What the thesis foresees, one element a pair."""

    occludes: np.ndarray  # bool
    seconds: np.ndarray  # from now; inf where never
    x: np.ndarray  # place, pixels; the middle between the two where never
    y: np.ndarray
    rule: np.ndarray  # CERTAIN, BY_SPEED, APART or UNIDENTIFIED


def order_walkers(x_p: ArrayLike, x_q: ArrayLike) -> np.ndarray:
    """Which of two walkers is S1: the one with the lesser abscissa (Algorithm 1).

    Parameters
    ----------
    x_p, x_q : array_like
        Columns of the centroids, pixels.

    Returns
    -------
    ndarray of int
        0 where S1 is the first walker (and S2 the second), 1 where S1 is the second,
        `UNIDENTIFIED` where both have the same abscissa.

    Raises
    ------
    ArgumentError
        When the columns are not finite or differ in shape, or one single pair has the
        same abscissa.
    """
    x_p, x_q = _pixels("x_p", x_p), _pixels("x_q", x_q)
    _require_one_shape(x_p=x_p, x_q=x_q)
    if x_p.ndim == 0 and x_p == x_q:
        raise ArgumentError(
            f"x_p and x_q are both {x_p:g}: no different subjects identified (Algorithm 1); "
            "pass two walkers whose centroids lie in different columns."
        )
    return np.where(x_p == x_q, UNIDENTIFIED, (x_p > x_q).astype(int))


def direction_rules() -> dict[str, np.ndarray]:
    """The three rules of section 3.3.1 as printed, each by itself.

    Returns
    -------
    dict
        "approaching", "departing", "same way" → ndarray of bool, shape (8, 8): rows
        D(S1) − 1, columns D(S2) − 1.
    """
    one, two = np.array(DIRECTIONS)[:, None], np.array(DIRECTIONS)
    toward_two, toward_one = (1, 2, 3, 4, 5), (1, 5, 6, 7, 8)
    neither = np.isin(one, (1, 5)) & np.isin(two, (1, 5))
    return {
        "approaching": np.isin(one, toward_two) & np.isin(two, toward_one) & ~neither,
        "departing": np.isin(one, toward_one) & np.isin(two, toward_two),
        "same way": np.logical_or(
            *(np.isin(one, side) & np.isin(two, side) for side in SIDES.values())
        ),
    }


def direction_table() -> np.ndarray:
    """Table 3.1: what two directions say.

    Returns
    -------
    ndarray of int, shape (8, 8)
        `APART`, `CERTAIN` or `BY_SPEED`; rows D(S1) − 1, columns D(S2) − 1.

    Examples
    --------
    Who walks right and who walks left towards him will meet:

    >>> bool(direction_table()[3 - 1, 7 - 1] == CERTAIN)
    True
    """
    rules = direction_rules()
    table = np.full((len(DIRECTIONS), len(DIRECTIONS)), APART)
    table[rules["approaching"]] = CERTAIN
    table[rules["same way"]] = BY_SPEED
    return table


def speed_table(side: str) -> np.ndarray:
    """Tables 3.2 and 3.3: whether the one behind is faster.

    Parameters
    ----------
    side : {"right", "left"}
        Both in directions 2, 3, 4 (Table 3.2: S1 is behind), or both in 6, 7, 8
        (Table 3.3: S2 is behind).

    Returns
    -------
    ndarray of bool, shape (3, 3)
        True where the thesis prints C; rows V(S1) − 1, columns V(S2) − 1.

    Examples
    --------
    >>> speed_table("right").astype(int)
    array([[0, 0, 0],
           [1, 0, 0],
           [1, 1, 0]])
    """
    require_choice("side", side, tuple(SIDES))
    one, two = np.array(LEVELS)[:, None], np.array(LEVELS)
    return one > two if side == "right" else one < two


def look_up(
    direction1: ArrayLike, direction2: ArrayLike, level1: ArrayLike, level2: ArrayLike
) -> np.ndarray:
    """What the two tables say together (section 3.3.1).

    Parameters
    ----------
    direction1, direction2 : array_like of int
        D(S1) and D(S2), 1 … 8.
    level1, level2 : array_like of int
        V(S1) and V(S2), 1 … 3.

    Returns
    -------
    ndarray of int
        `CERTAIN`; `BY_SPEED` where time and place must be computed; `APART`.

    Raises
    ------
    ArgumentError
        When a direction or level is no such number, or shapes differ.
    """
    given = {
        "direction1": _whole("direction1", direction1, DIRECTIONS),
        "direction2": _whole("direction2", direction2, DIRECTIONS),
        "level1": _whole("level1", level1, LEVELS),
        "level2": _whole("level2", level2, LEVELS),
    }
    _require_one_shape(**given)
    one, two, v1, v2 = (values - 1 for values in given.values())
    code = direction_table()[one, two]
    rightward = np.isin(one + 1, SIDES["right"])
    catches = np.where(rightward, speed_table("right")[v1, v2], speed_table("left")[v1, v2])
    return np.where((code == BY_SPEED) & ~catches, APART, code)


def seconds_to_meet(
    distance: ArrayLike, pixels1: ArrayLike, pixels2: ArrayLike, *, same_way: ArrayLike = False
) -> np.ndarray:
    """Time to the occlusion (Equation 3.1), had both walked on the line between them.

    d / (p1 + p2) for walkers approaching each other, d / |p1 − p2| for walkers going the
    same way.  Times the frame rate it is the number of frames from now.

    Parameters
    ----------
    distance : array_like
        d, pixels between the centroids.
    pixels1, pixels2 : array_like
        p1 and p2, pixels travelled in one second.
    same_way : bool or array_like of bool, optional

    Returns
    -------
    ndarray
        Seconds; inf, for never, where they close in by no more than `STILL`: equal speeds
        the same way, or both standing.

    Raises
    ------
    ArgumentError
        When a number is negative or not finite, or shapes differ.
    """
    distance = _pixels("distance", distance, low=0, high=4 * PIXEL_LIMIT)
    pixels1 = _pixels("pixels1", pixels1, low=0)
    pixels2 = _pixels("pixels2", pixels2, low=0)
    same_way = np.asarray(same_way, dtype=bool)
    _require_one_shape(distance=distance, pixels1=pixels1, pixels2=pixels2)
    if same_way.ndim:
        _require_one_shape(distance=distance, same_way=same_way)
    closing = np.where(same_way, np.abs(pixels1 - pixels2), pixels1 + pixels2)
    meets = closing > STILL
    return np.where(meets, distance / np.where(meets, closing, 1.0), np.inf)


def place_printed(
    subject1: Walker, subject2: Walker, *, same_way: ArrayLike = False
) -> tuple[np.ndarray, np.ndarray]:
    """Equations 3.5 and 3.6 exactly as printed.

    Their algebra is right: 3.3 taken from 3.2, and 3.4 put in, gives 3.5 sign by sign.
    But the difference of two equations says less than both.  It is a straight line, square
    to the line between the walkers and D1 from S1 along it, and the printed place is where
    S1's line of motion crosses it: D1 / cos θ from S1, where θ is the angle between S1's
    motion and the line to S2 (−D1 / cos θ where S2 chases S1).  So it is D1 away, as 3.2
    wants, only when both walk on one line.  Otherwise it lies too far off, out to infinity
    as θ nears 90°, and beyond 90° behind S1's back: a slope does not know which way along
    it S1 walks.

    Parameters
    ----------
    subject1, subject2 : Walker
        S1 and S2, as `order_walkers` tells them apart.
    same_way : bool or array_like of bool, optional

    Returns
    -------
    x, y : ndarray
        Pixels.

    Raises
    ------
    ArgumentError
        Where the form has no answer: S1 moves vertically (m is infinite) or not at all, or
        square to the line between the two (the denominator is 0), or the two never meet.
        `place_reached` answers all but the last.
    """
    one, two, seconds = _check_meeting(subject1, subject2, same_way)
    _refuse(
        np.abs(one.vx) <= np.abs(one.vy) / STEEPEST,
        "subject1 moves vertically or not at all, so it has no slope",
        "use place_reached",
    )
    m = one.vy / one.vx
    across, down = one.x - two.x, one.y - two.y
    denominator = 2 * m * down + 2 * across
    _refuse(
        denominator == 0,
        "subject1 moves square to the line between the two",
        "use place_reached",
    )
    d1, d2 = one.pixels * seconds, two.pixels * seconds
    x = (
        2 * (m * one.x - one.y) * down
        - (d1**2 - d2**2)
        + (one.x**2 - two.x**2)
        + (one.y**2 - two.y**2)
    ) / denominator
    return x, -m * one.x + one.y + m * x


def place_reached(
    subject1: Walker, subject2: Walker, *, same_way: ArrayLike = False, of: str = "both"
) -> tuple[np.ndarray, np.ndarray]:
    """Where the walkers have got to at the time of Equation 3.1: safe for any motion.

    S1 walks D1 = p1·t along its own direction of motion, S2 walks D2 = p2·t.  Head-on
    both end in one place, which is that of Equations 3.5 and 3.6.

    Parameters
    ----------
    subject1, subject2 : Walker
        S1 and S2.
    same_way : bool or array_like of bool, optional
    of : {"both", "first"}, optional
        "both": the middle between the two ends, so that a mirrored scene has the mirrored
        place.  "first": the end of S1 alone, as Equations 3.2 and 3.4 have it.

    Returns
    -------
    x, y : ndarray
        Pixels.

    Raises
    ------
    ArgumentError
        When a walker's numbers are not sound, or the two never meet.
    """
    require_choice("of", of, ("both", "first"))
    one, two, seconds = _check_meeting(subject1, subject2, same_way)
    return _place(one, two, seconds, of)


def inconsistency(subject1: Walker, subject2: Walker, *, same_way: ArrayLike = False) -> np.ndarray:
    """By how much Equations 3.2 to 3.4 contradict each other, pixels (misprint 5).

    S1's end satisfies 3.2 and 3.4.  3.3 wants it D2 from S2; the answer is by how much it
    is not.  It is 0 only where S1 walks straight at S2, or straight away from an S2 that
    chases it, or stands still.  For walkers approaching each other, with θ as in
    `place_printed`, it is

        √(D2² + 2·d·D1·(1 − cos θ)) − D2.

    Parameters
    ----------
    subject1, subject2 : Walker
        S1 and S2.
    same_way : bool or array_like of bool, optional

    Returns
    -------
    ndarray
        Pixels, at least 0.

    Raises
    ------
    ArgumentError
        When a walker's numbers are not sound, or the two never meet.
    """
    one, two, seconds = _check_meeting(subject1, subject2, same_way)
    x, y = _place(one, two, seconds, "first")
    return np.abs(np.hypot(x - two.x, y - two.y) - two.pixels * seconds)


def foresee(
    first: Walker,
    second: Walker,
    *,
    frame_width: float,
    frame_height: float,
    slow: float = SLOW,
    fast: float = FAST,
    of: str = "both",
) -> Foreseen:
    """Whether, when and where pairs of walkers cover each other, as the thesis says.

    Parameters
    ----------
    first, second : Walker
        The pairs; either walker may be first.
    frame_width, frame_height : float
        Pixels.  Walkers going the same way whose place lies outside the frame do not
        occlude; for certain cases the thesis asks for no such test (misprint 8).
    slow, fast : float, optional
        Shares of the frame's width at which the speed levels part (section 3.2.2).
    of : {"both", "first"}, optional
        Whose end is the place, see `place_reached`.

    Returns
    -------
    Foreseen

    Raises
    ------
    ArgumentError
        When a number is not finite or out of range, shapes differ, or one single pair has
        the same abscissa.

    Examples
    --------
    Two walk towards each other at 50 pixels a second each, 100 pixels apart:

    >>> one, two = Walker(100, 80, 3, 50, 50, 0), Walker(200, 80, 7, 50, -50, 0)
    >>> said = foresee(one, two, frame_width=352, frame_height=240)
    >>> bool(said.occludes), float(said.seconds), float(said.x)
    (True, 1.0, 150.0)
    """
    frame_width = require_number("frame_width", frame_width, above=0, unit="pixels")
    frame_height = require_number("frame_height", frame_height, above=0, unit="pixels")
    require_choice("of", of, ("both", "first"))
    first, second = _check_walker("first", first), _check_walker("second", second)
    _require_one_shape(first=first.x, second=second.x)
    order = order_walkers(first.x, second.x)
    one = Walker(*(np.where(order == 1, q, p) for p, q in zip(first, second, strict=True)))
    two = Walker(*(np.where(order == 1, p, q) for p, q in zip(first, second, strict=True)))
    level1, level2 = (
        level_of(subject.pixels, frame_width=frame_width, slow=slow, fast=fast)
        for subject in (one, two)
    )
    rule = look_up(one.direction, two.direction, level1, level2)
    rule = np.where(order == UNIDENTIFIED, UNIDENTIFIED, rule)
    seconds = _meeting(one, two, rule == BY_SPEED)
    meets = np.isin(rule, (CERTAIN, BY_SPEED)) & np.isfinite(seconds)
    x, y = _place(one, two, np.where(meets, seconds, 0.0), of)
    # Pixels count from the centre of the top-left one, so the frame begins at −½.
    inside = (np.abs(x - (frame_width - 1) / 2) <= frame_width / 2) & (
        np.abs(y - (frame_height - 1) / 2) <= frame_height / 2
    )
    occludes = meets & (inside | (rule == CERTAIN))
    return Foreseen(
        occludes,
        np.where(occludes, seconds, np.inf),
        np.where(occludes, x, (one.x + two.x) / 2),
        np.where(occludes, y, (one.y + two.y) / 2),
        rule,
    )


def _meeting(one, two, same_way):
    """Seconds until S1 and S2 meet, from the distance between their centroids."""
    _require_one_shape(subject1=one.x, subject2=two.x)
    distance = np.hypot(two.x - one.x, two.y - one.y)
    return seconds_to_meet(distance, one.pixels, two.pixels, same_way=same_way)


def _check_meeting(subject1, subject2, same_way):
    """S1 and S2, both sound, and the seconds until they meet; an `ArgumentError` if never."""
    one, two = _check_walker("subject1", subject1), _check_walker("subject2", subject2)
    seconds = _meeting(one, two, same_way)
    _refuse(np.isinf(seconds), "subject1 and subject2 never meet", "leave that pair out")
    return one, two, seconds


def _place(one, two, seconds, of):
    """Where S1, or the middle of both, is after `seconds`."""
    ends = []
    for subject in (one, two) if of == "both" else (one,):
        length = np.hypot(subject.vx, subject.vy)
        # Nobody who moves has length 0; whoever stands still goes nowhere.
        length = np.where(length > 0, length, 1.0)
        walked = subject.pixels * seconds
        ends.append(
            (subject.x + walked * (subject.vx / length), subject.y + walked * (subject.vy / length))
        )
    xs, ys = zip(*ends, strict=True)
    return sum(xs) / len(ends), sum(ys) / len(ends)


def _check_walker(name, walker):
    """`walker` as float arrays of one shape, or an `ArgumentError`."""
    try:
        x, y, direction, pixels, vx, vy = walker
    except (TypeError, ValueError):
        raise ArgumentError(
            f"{name} is a {type(walker).__name__} without the six fields of a Walker; "
            "pass Walker(x, y, direction, pixels, vx, vy)."
        ) from None
    sound = Walker(
        _pixels(f"{name}.x", x),
        _pixels(f"{name}.y", y),
        _whole(f"{name}.direction", direction, DIRECTIONS),
        _pixels(f"{name}.pixels", pixels, low=0),
        _pixels(f"{name}.vx", vx),
        _pixels(f"{name}.vy", vy),
    )
    _require_one_shape(**{f"{name}.{field}": values for field, values in sound._asdict().items()})
    _refuse(
        (sound.pixels > STILL) & (sound.vx == 0) & (sound.vy == 0),
        f"{name} travels some pixels, but vx and vy are 0",
        "pass the way it moves",
    )
    return sound


def _pixels(
    name: str, values: ArrayLike, *, low: float = -PIXEL_LIMIT, high: float = PIXEL_LIMIT
) -> np.ndarray:
    """`values` as a float array of finite numbers of pixels, at most as many as any image has."""
    return require_array(name, values, low=low, high=high)


def _whole(name: str, values: ArrayLike, choices: tuple[int, ...]) -> np.ndarray:
    """`values` as an int array of numbers from the first choice to the last."""
    return require_array(name, values, dtype=int, low=choices[0], high=choices[-1])


def _require_one_shape(**arrays):
    """Raise `ArgumentError` unless all arrays have one shape."""
    if len({values.shape for values in arrays.values()}) > 1:
        listed = ", ".join(f"{name} {values.shape}" for name, values in arrays.items())
        raise ArgumentError(f"shapes differ: {listed}; pass one element a pair in each.")


def _refuse(wrong, what, remedy):
    """Raise `ArgumentError` naming the first pair where `wrong`."""
    if wrong.any():
        where = f" in pair {int(np.flatnonzero(wrong)[0])}" if wrong.ndim else ""
        raise ArgumentError(f"{what}{where}; {remedy}.")
