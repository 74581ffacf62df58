"""Timings, each against a peer: ``bench.csv`` with ``id, ours, peer, ratio, unit``.

Ours and the peer take turns, so that a machine whose speed drifts treats both alike; the
numbers are medians, the ratio the median of the pairs' ratios.
"""

import subprocess
import sys
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np
import pandas as pd

from mcnlab import bundled, widgets
from mcnlab.datasets.walkers import make_walks
from mcnlab.evaluation import read_heading, sample_sequences
from mcnlab.files import write_whole
from mcnlab.silhouettes import measure_sequences

FOCAL_LENGTH = 450.0  # pixels
ROUNDS = 3


def bench(out):
    """Run every benchmark and write ``bench.csv``.

    Parameters
    ----------
    out : path-like
        A folder.

    Returns
    -------
    pathlib.Path
        The file.
    """
    from tqdm.auto import tqdm

    rows = []
    for benchmark in tqdm((time_import, time_videos, time_all_videos, time_panels), unit="bench"):
        rows += benchmark()
    table = pd.DataFrame(rows, columns=["id", "ours", "peer", "ratio", "unit"])
    text = table.to_csv(index=False, lineterminator="\n", float_format="%.5g")
    return write_whole(Path(out) / "bench.csv", text)


def time_import():
    """``import mcnlab`` in a new process, against an empty one."""

    def run(code):
        subprocess.run([sys.executable, "-c", code], check=True)

    ours, peer = _take_turns(lambda: run("import mcnlab"), lambda: run("pass"), rounds=7)
    return [_row("import.mcnlab", ours, peer)]


def time_videos():
    """Reading, measuring and deciding a video, against only decoding its images."""
    ours, peer = [], []
    with sample_sequences(most=40) as sequences:
        for sequence in sequences:
            paths = [str(path) for path in sequence.paths]
            turns = _take_turns(
                lambda: read_heading(sequence, focal_length=FOCAL_LENGTH),  # noqa: B023
                lambda: [cv2.imread(path, cv2.IMREAD_GRAYSCALE) for path in paths],  # noqa: B023
                rounds=ROUNDS,
            )
            ours.append(np.median(turns[0]))
            peer.append(np.median(turns[1]))
    # Means over videos, as the thesis reports them.
    mean, decode = float(np.mean(ours)), float(np.mean(peer))
    return [("direction.measure-vs-decode", mean, decode, mean / decode, "s a video")]


def time_all_videos():
    """Measuring all videos on two cores, against one."""
    with sample_sequences(most=10_000 if bundled.casia_a_folder() else 80) as sequences:
        measure_sequences(sequences[:4], n_jobs=2)  # the workers' start is not the measuring
        ours, peer = _take_turns(
            lambda: measure_sequences(sequences, n_jobs=2),
            lambda: measure_sequences(sequences, n_jobs=1),
            rounds=ROUNDS,
        )
    return [_row(f"direction.{len(sequences)}-videos.two-cores-vs-one", ours, peer)]


def time_panels():
    """From a slider's move to the redrawn figure, one row a panel and one over all."""
    casia = bundled.casia_a()
    masks = make_walks(subjects=1, directions=(3,), seed=0)[0].masks
    moves = {
        "silhouette": (widgets.silhouette_panel(masks), "min_area", range(5, 25)),
        "mirror": (widgets.mirror_panel(casia), "every", range(3, 23)),
        "phase": (widgets.phase_panel(casia), "spacing", [2, 3, 4, 6, 7, 8] * 3),
        "separator": (widgets.separator_panel(casia), "spacing", [2, 3, 4, 6, 7, 8] * 3),
        "heading": (
            widgets.heading_panel(casia, focal_length=FOCAL_LENGTH),
            "focal_length",
            range(300, 500, 10),
        ),
    }
    rows, every = [], []
    for name, (panel, control, values) in moves.items():
        seconds = []
        for value in values:
            begin = perf_counter()
            panel.controls[control].value = value
            seconds.append(perf_counter() - begin)
        every += seconds
        rows.append((f"widgets.direction.{name}", float(np.median(seconds)), None, None, "s"))
    return [("widgets.direction", float(np.median(every)), None, None, "s"), *rows]


def _take_turns(ours, peer, *, rounds):
    """Seconds of each, run one after the other `rounds` times after a warm-up."""
    cv2.setNumThreads(1)
    seconds = ([], [])
    try:
        for turn in range(rounds + 1):
            for run, kept in zip((ours, peer), seconds, strict=True):
                begin = perf_counter()
                run()
                if turn:
                    kept.append(perf_counter() - begin)
    finally:
        cv2.setNumThreads(-1)
    return seconds


def _row(name, ours, peer):
    ratio = np.median(np.array(ours) / np.array(peer))
    return (name, float(np.median(ours)), float(np.median(peer)), float(ratio), "s")
