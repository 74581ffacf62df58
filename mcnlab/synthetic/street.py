"""Two walks in one frame: how the thesis makes its occlusions (sections 3.4 and 3.5).

People are filmed one at a time; two walks of one camera, laid over each other in one
clock, are two people who never met.  Nobody gives way, and nobody hides the other from
whatever measured the boxes: the truth of a composite is known in every frame.

Where nobody was filmed as a case wants it, there is a made street: wider and deeper than
CASIA A's room, so that it holds people who are slow in the image.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pandas as pd

from mcnlab.cameras.camera import Camera
from mcnlab.checks import require_count
from mcnlab.compass import heading_of
from mcnlab.datasets.recording import Recording
from mcnlab.synthetic.body import Body, draw_body
from mcnlab.synthetic.walkers import make_walk
from mcnlab.tables import AREA, BOX_COLUMNS, H, W, X, Y

STREET_NAME = "street"
STREET = Camera.from_tilt(focal_length=450, height=1.6, tilt=4, frame_width=960, frame_height=540)
STREET_RATE = 25.0  # frames a second
# Direction → metres ahead of the camera in mid-walk, and at the farthest.
_BRISK = {2: (6.5, 8.5), 3: (7.0, 50.0), 6: (6.0, 8.0), 7: (7.5, 50.0)}
# Who dawdles takes half a step a second or so, far away: under 1 % of the width a second.
_DAWDLE = {"stride": 0.2, "cadence": 1.0, "arm_swing": 0.4}
_DAWDLE_PLACE = (12.0, 14.0), (-2.0, 2.0)  # metres ahead, and to the right
_FRAMES = 120


class Street(NamedTuple):
    """A made street: its box table, and each walker cut out of each frame."""

    recording: Recording
    cut_outs: dict  # sequence → list of masks, one a frame, each as large as its box

    def masks(self, name: str) -> np.ndarray:
        """The silhouettes of one walk, shape (frames, height, width), uint8."""
        rows = self.recording.sequence(name)
        size = self.recording.frame_height, self.recording.frame_width
        masks = np.zeros((len(rows), *size), np.uint8)
        for mask, row, body in zip(masks, rows.itertuples(), self.cut_outs[name], strict=True):
            mask[row.y : row.y + row.h, row.x : row.x + row.w] = body
        return masks


@lru_cache(maxsize=4)
def make_street(
    *, brisk: int = 3, dawdlers: int = 5, seed: int = 5, view: Camera = STREET
) -> Street:
    """People on a wide street: some walk briskly past, some dawdle in the distance.

    Parameters
    ----------
    brisk : int, optional
        People; each walks once in each of the directions 2, 3, 6 and 7, a few metres from
        the camera.
    dawdlers : int, optional
        People; each dawdles once in direction 3, twelve metres away or more.
    seed : int, optional
    view : Camera, optional
        From where the same walks are seen; default: at eye level.

    Returns
    -------
    Street
        Sequences ``s01-d3`` and so on, and ``dawdler-1``; frames from 1, with the true
        directions as labels.

    Raises
    ------
    ArgumentError
        When a number is not a count, or the view does not show a walker whole.

    Examples
    --------
    >>> street = make_street(brisk=1, dawdlers=0)
    >>> list(street.recording.sequences)
    ['s01-d2', 's01-d3', 's01-d6', 's01-d7']
    """
    require_count("brisk", brisk, low=1)
    require_count("dawdlers", dawdlers)
    require_count("seed", seed)
    walks = []
    for number in range(1, brisk + 1):
        body = draw_body(np.random.default_rng([seed, number]))
        for direction, (distance, farthest) in _BRISK.items():
            walks.append(
                make_walk(
                    body,
                    heading=float(heading_of(direction)),
                    view=view,
                    distance=distance,
                    farthest=farthest,
                    max_frames=_FRAMES,
                    frame_rate=STREET_RATE,
                    name=f"s{number:02d}-d{direction}",
                    subject=f"s{number:02d}",
                )
            )
    for number in range(1, dawdlers + 1):
        rng = np.random.default_rng([seed, 100 + number])
        body = Body(stature=rng.uniform(1.6, 1.8), phase=rng.uniform(), **_DAWDLE)
        distance, offset = (rng.uniform(*bounds) for bounds in _DAWDLE_PLACE)
        walks.append(
            make_walk(
                body,
                heading=90.0,
                view=view,
                distance=distance,
                offset=offset,
                n_frames=_FRAMES,
                frame_rate=STREET_RATE,
                name=f"dawdler-{number}",
                subject=f"dawdler-{number}",
            )
        )
    boxes = pd.concat([walk.truth for walk in walks], ignore_index=True)
    recording = Recording(
        STREET_NAME,
        boxes[[*BOX_COLUMNS, AREA]],
        STREET_RATE,
        view.frame_width,
        view.frame_height,
        directions=pd.Series({walk.name: walk.direction for walk in walks}),
        source="synthetic",
    )
    return Street(recording, {walk.name: _cut_out(walk) for walk in walks})


def _cut_out(walk):
    """Each frame's silhouette in its box: a hundredth of the whole masks."""
    boxes = walk.truth[[X, Y, W, H]].to_numpy()
    return [
        mask[y : y + h, x : x + w].copy()
        for mask, (x, y, w, h) in zip(walk.masks, boxes, strict=True)
    ]
