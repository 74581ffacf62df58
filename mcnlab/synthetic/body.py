"""The articulated body: segments, joint angles and radii, as capsules in the world."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from mcnlab.checks import require_number

# Every tenth of the cycle from heel contact, degrees: thigh forward of vertical, knee
# flexion, ankle dorsiflexion.
_THIGH: Final = (25, 25, 15, 1, -11, -20, -14, 1, 20, 32)
_KNEE: Final = (3, 18, 17, 13, 9, 13, 30, 61, 56, 20)
_ANKLE: Final = (3, -6, 2, 8, 10, 11, -15, -11, -1, 1)

_LEG_ANGLES: Final = CubicSpline(
    np.linspace(0.0, 1.0, 11),
    np.radians([(*angles, angles[0]) for angles in (_THIGH, _KNEE, _ANKLE)]).T,
    bc_type="periodic",
)

# Arm: (mean, amplitude) of the shoulder's flexion and the elbow's, lowest at the contact of
# the heel on the same side.
_SHOULDER: Final = (-8.0, 16.0)
_ELBOW: Final = (25.0, 12.0)
# Fractions of stature.
_THIGH_LENGTH: Final = 0.245
_SHANK_LENGTH: Final = 0.246
_UPPER_ARM_LENGTH: Final = 0.186
_FOREARM_LENGTH: Final = 0.146
_HAND_LENGTH: Final = 0.070  # of a half-closed hand; stretched it is 0.108

# The balls that capsules join, with lateral, upward and forward offset from the mid-point
# between the hips, and radius.  Both sides are listed; left is negative.
_TRUNK: Final = {
    "crown": (0.0, 0.415, 0.010, 0.055),
    "jaw": (0.0, 0.376, 0.016, 0.049),
    "nape": (0.0, 0.285, 0.002, 0.052),
    "left chest": (-0.060, 0.205, 0.000, 0.076),
    "right chest": (0.060, 0.205, 0.000, 0.076),
    "left waist": (-0.056, 0.050, 0.002, 0.074),
    "right waist": (0.056, 0.050, 0.002, 0.074),
    "left shoulder": (-0.098, 0.250, 0.000, 0.045),
    "right shoulder": (0.098, 0.250, 0.000, 0.045),
}

# Sideways position and radius along a limb.  Legs close in towards a walking base of about
# 0.07 of stature; arms hang a little outwards.
_LEG: Final = {
    "hip": (0.052, 0.068),
    "knee": (0.046, 0.051),
    "ankle": (0.038, 0.038),
    "heel": (0.036, 0.022),
    "ball": (0.042, 0.020),
    "toe": (0.045, 0.014),
}

_ARM: Final = {
    "elbow": (0.146, 0.039),
    "wrist": (0.154, 0.031),
    "hand": (0.150, 0.026),
}

# Foot, in its own frame: forward and up from the ankle.  The sole is one radius lower.
_FOOT: Final = {"heel": (-0.029, -0.017), "ball": (0.072, -0.021)}
_TOE_LENGTH: Final = 0.034

_CAPSULES: Final = (
    ("head", "crown", "jaw"),
    ("head", "jaw", "nape"),
    ("torso", "nape", "left shoulder"),
    ("torso", "nape", "right shoulder"),
    ("torso", "left shoulder", "left waist"),
    ("torso", "right shoulder", "right waist"),
    ("torso", "left chest", "right chest"),
    ("torso", "left chest", "left waist"),
    ("torso", "right chest", "right waist"),
    ("torso", "left waist", "right waist"),
    ("torso", "left waist", "left hip"),
    ("torso", "right waist", "right hip"),
    *(
        (f"{side} {limb}", f"{side} {start}", f"{side} {stop}")
        for side in ("left", "right")
        for limb, start, stop in (
            ("arm", "shoulder", "elbow"),
            ("arm", "elbow", "wrist"),
            ("arm", "wrist", "hand"),
            ("thigh", "hip", "knee"),
            ("shin", "knee", "ankle"),
            ("foot", "heel", "ball"),
            ("foot", "ankle", "heel"),
            ("foot", "ankle", "ball"),
            ("foot", "ball", "toe"),
        )
    ),
)

JOINTS: Final = (
    *_TRUNK,
    *(f"{side} {name}" for side in ("left", "right") for name in (*_LEG, *_ARM)),
)

LIMBS: Final = tuple(dict.fromkeys(limb for limb, _, _ in _CAPSULES))
_INDEX: Final = {name: row for row, name in enumerate(JOINTS)}
_IS_FOOT: Final = np.array([name.split()[-1] in ("heel", "ball", "toe") for name in JOINTS])

_RADII: Final = np.array(
    [
        *(entry[3] for entry in _TRUNK.values()),
        *(entry[1] for _ in range(2) for entry in (*_LEG.values(), *_ARM.values())),
    ]
)

_CYCLE_SAMPLES: Final = 400


@dataclass(frozen=True)
class Body:
    """One walker's build and gait.

    Attributes
    ----------
    stature : float
        Metres.
    build : float
        Multiplies every radius but the feet's; 1 is an adult in a light coat.
    cadence : float
        Steps a second.
    stride : float
        Multiplies the thigh's angles, and so the length of the steps.
    arm_swing : float
        Multiplies the arms' swing.
    arm_bias : float
        −1 … 1: how much more the right arm swings than the left.
    lean : float
        The trunk's forward lean, degrees.
    phase : float
        Gait phase in the first frame, in cycles; 0 is the right heel's contact.
    """

    stature: float = 1.70
    build: float = 1.0
    cadence: float = 1.9
    stride: float = 1.0
    arm_swing: float = 1.0
    arm_bias: float = 0.0
    lean: float = 4.0
    phase: float = 0.0

    def __post_init__(self) -> None:
        require_number("stature", self.stature, above=0, unit="metres")
        require_number("build", self.build, above=0)
        require_number("cadence", self.cadence, above=0, unit="steps a second")
        require_number("stride", self.stride, above=0, high=2)
        require_number("arm_swing", self.arm_swing, low=0, high=4)
        require_number("arm_bias", self.arm_bias, low=-1, high=1)
        require_number("lean", self.lean, low=-45, high=45, unit="degrees")
        require_number("phase", self.phase)

    @property
    def step_length(self) -> float:
        """Metres from one foot's contact to the other's."""
        return self.stature * _cycle(self.stride)[2] / 2

    @property
    def speed(self) -> float:
        """Mean walking speed, metres a second."""
        return self.step_length * self.cadence

    def mirrored(self) -> "Body":
        """The same walker with left and right exchanged."""
        return replace(self, phase=(self.phase + 0.5) % 1.0, arm_bias=-self.arm_bias)


def draw_body(rng: np.random.Generator) -> Body:
    """A body with a random build and gait.

    Parameters
    ----------
    rng : numpy.random.Generator

    Returns
    -------
    Body
        Stature 1.55–1.90 m and cadence 1.75–2.1 steps a second, within the published
        ranges of healthy adults; speed then is about 0.75–0.95 statures a second.
    """

    def normal(mean, deviation, low, high):
        return float(np.clip(rng.normal(mean, deviation), low, high))

    return Body(
        stature=normal(1.70, 0.08, 1.55, 1.90),
        build=normal(1.0, 0.07, 0.85, 1.2),
        cadence=normal(1.91, 0.08, 1.75, 2.1),
        stride=normal(1.0, 0.06, 0.85, 1.15),
        arm_swing=normal(0.9, 0.2, 0.4, 1.4),
        arm_bias=normal(0.0, 0.2, -0.5, 0.5),
        lean=normal(4.0, 2.0, 0.0, 9.0),
        phase=float(rng.uniform()),
    )


def _radii(body):
    """The joints' radii in metres.  Build is clothes and flesh: the feet keep theirs."""
    return body.stature * _RADII * np.where(_IS_FOOT, 1.0, body.build)


def _leg(phase, stride):
    """A leg's joints in the plane of walking.

    Parameters
    ----------
    phase : ndarray, shape (n,)
        Cycles from this leg's heel contact.
    stride : float

    Returns
    -------
    ndarray, shape (n, 6, 2)
        Forward and up from the hip in statures, in the order of `_LEG`.
    """
    thigh, knee, ankle = _LEG_ANGLES(phase % 1.0).T
    thigh = stride * thigh
    shank = thigh - knee
    pitch = shank + ankle
    # Behind the ball of the foot the heel rises while the toes stay on the ground.
    toes = np.where(pitch < 0, 0.4 * pitch, pitch)
    points = np.zeros((len(phase), len(_LEG), 2))
    points[:, 1] = _THIGH_LENGTH * _hanging(thigh)
    points[:, 2] = points[:, 1] + _SHANK_LENGTH * _hanging(shank)
    ahead = np.stack([np.cos(pitch), np.sin(pitch)], axis=1)
    upward = np.stack([-np.sin(pitch), np.cos(pitch)], axis=1)
    for row, name in ((3, "heel"), (4, "ball")):
        forward, up = _FOOT[name]
        points[:, row] = points[:, 2] + forward * ahead + up * upward
    points[:, 5] = points[:, 4] + _TOE_LENGTH * np.stack([np.cos(toes), np.sin(toes)], axis=1)
    return points


def _hanging(angle):
    """Unit vectors (forward, up) that hang down, swung forward by `angle` in radians."""
    return np.stack([np.sin(angle), -np.cos(angle)], axis=1)


@lru_cache(maxsize=256)
def _cycle(stride):
    """How the pelvis moves in one gait cycle, in statures.

    The lowest heel or ball of the foot is on the ground.  Each leg carries from its heel
    contact to the other's: its lowest point then stays where it is, and the pelvis passes
    over it.

    Returns
    -------
    height : ndarray, shape (_CYCLE_SAMPLES,)
        Of the hips above the ground.
    lead : ndarray, shape (_CYCLE_SAMPLES,)
        How far the pelvis is ahead of an even pace.
    length : float
        Of a stride.
    """
    phase = np.arange(_CYCLE_SAMPLES) / _CYCLE_SAMPLES
    heel_and_ball = _leg(phase, stride)[:, 3:5]
    sole = heel_and_ball[..., 1] - (_LEG["heel"][1], _LEG["ball"][1])
    lowest = sole.min(axis=1)
    height = -np.minimum(lowest, np.roll(lowest, _CYCLE_SAMPLES // 2))
    rows = np.arange(_CYCLE_SAMPLES // 2)
    carrier = sole.argmin(axis=1)[rows]
    forward = heel_and_ball[..., 0]
    step = np.tile(forward[rows, carrier] - forward[rows + 1, carrier], 2)
    length = float(step.sum())
    lead = np.concatenate([[0.0], step.cumsum()[:-1]]) - length * phase
    return height, lead - lead.mean(), length


def _periodic(phase, table):
    """`table` over one cycle, read at `phase` in cycles."""
    return np.interp(phase, np.arange(_CYCLE_SAMPLES) / _CYCLE_SAMPLES, table, period=1.0)


def _pose(body, phase):
    """The joints from the point between the hips: right, up, forward in statures."""
    pose = np.empty((len(phase), len(JOINTS), 3))
    trunk = np.array([entry[:3] for entry in _TRUNK.values()])
    lean = math.radians(body.lean)
    pose[:, : len(_TRUNK), 0] = trunk[:, 0]
    pose[:, : len(_TRUNK), 1] = trunk[:, 1] * math.cos(lean) - trunk[:, 2] * math.sin(lean)
    pose[:, : len(_TRUNK), 2] = trunk[:, 2] * math.cos(lean) + trunk[:, 1] * math.sin(lean)
    for side, name, shift in ((-1, "left", 0.5), (1, "right", 0.0)):
        legs = slice(_INDEX[f"{name} hip"], _INDEX[f"{name} toe"] + 1)
        pose[:, legs, 0] = side * np.array([entry[0] for entry in _LEG.values()])
        pose[:, legs, 2:0:-1] = _leg(phase + shift, body.stride)
        # The arm is farthest back when the heel on its own side touches the ground.
        swing = -np.cos(2 * math.pi * (phase + shift)) * body.arm_swing
        swing *= 1 + side * body.arm_bias
        upper = np.radians(_SHOULDER[0] + _SHOULDER[1] * swing)
        lower = upper + np.radians(_ELBOW[0] + _ELBOW[1] * swing)
        arms = slice(_INDEX[f"{name} elbow"], _INDEX[f"{name} hand"] + 1)
        pose[:, arms, 0] = side * np.array([entry[0] for entry in _ARM.values()])
        bones = [
            _UPPER_ARM_LENGTH * _hanging(upper),
            _FOREARM_LENGTH * _hanging(lower),
            _HAND_LENGTH * _hanging(lower),
        ]
        shoulder = pose[:, _INDEX[f"{name} shoulder"], 2:0:-1]
        pose[:, arms, 2:0:-1] = shoulder[:, None] + np.cumsum(np.stack(bones, axis=1), axis=1)
    return pose
