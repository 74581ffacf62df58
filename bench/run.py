"""Timings, each against a peer: ``bench.csv`` with ``id, ours, peer, ratio, unit``.

Ours and the peer take turns, so that a machine whose speed drifts treats both alike; the
numbers are medians, the ratio the median of the pairs' ratios.  Peers that are libraries of
others run in an environment of their own (see `peers`), whose Python ``MCNLAB_PEERS`` names;
without it their rows have no peer.
"""

import json
import os
import subprocess
import sys
import tempfile
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np
import pandas as pd

from bench import peers
from mcnlab import widgets
from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets import catalogue
from mcnlab.errors import McnError
from mcnlab.files import write_whole
from mcnlab.occlusion import forecasters
from mcnlab.occlusion.benchmark import (
    compare_composites,
    compare_crossings,
    judge,
    learn,
    video_pairs,
)
from mcnlab.occlusion.pairs import find_pairs, watch
from mcnlab.placement import cells, choice, votes
from mcnlab.placement.site import prepare_site
from mcnlab.synthetic import corridor, crossings, overhead
from mcnlab.synthetic.shifts import make_motion
from mcnlab.synthetic.walkers import make_walks
from mcnlab.vision import flow, recordings
from mcnlab.vision.silhouettes import measure_sequences
from mcnlab.walking import outdoors, viewpoint
from mcnlab.walking.evaluation import read_heading, sample_sequences

FOCAL_LENGTH = 450.0  # pixels
ROUNDS = 3
PEERS = "MCNLAB_PEERS"  # the Python of the peers' environment


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
    benchmarks = (
        time_import,
        time_videos,
        time_all_videos,
        time_flow,
        time_votes,
        time_choices,
        time_foresight,
        time_panels,
        time_siting_panels,
        time_occlusion_panels,
    )
    for benchmark in tqdm(benchmarks, unit="bench"):
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


def time_flow():
    """Horn and Schunck as in 1981 against pyoptflow's; the pyramid against today's flows.

    One thread each.  The shift is (0.4, 0.3) pixels for the former, (3, 2) for the latter,
    both frames 640×480.
    """
    rows = []
    with _peers() as ask, tempfile.TemporaryDirectory() as folder:
        small = make_motion("creeping", shape=(480, 640))
        data = _save(folder, "small", first=small.first, second=small.second, truth=small.truth)
        options = {"alpha": flow.ALPHA, "iterations": 100}  # where the peer errs least, too

        def plain():
            return flow.horn_schunck_plain(small.first, small.second, **options)

        name = "flow.horn-schunck-vs-pyoptflow"
        rows += _against(name, plain, ask("pyoptflow", data, **options), truth=small.truth)
        large = make_motion("shifting", shape=(480, 640))
        data = _save(folder, "large", first=large.first, second=large.second, truth=large.truth)
        pair = (large.first, large.second)
        for name, peer in {
            "farneback": _timed(lambda: flow.farneback(*pair), truth=large.truth),
            "dis": _timed(lambda: flow.dis(*pair), truth=large.truth),
            "tv-l1": ask("tv-l1", data),
            "ilk": ask("ilk", data),
        }.items():
            ours = lambda: flow.horn_schunck(*pair)  # noqa: E731
            rows += _against(f"flow.pyramid-vs-{name}", ours, peer, truth=large.truth)
    return rows


def time_votes():
    """Votes of 1,000×1,000 directed cells, and the slider's part of the whole chain."""
    rng = np.random.default_rng(0)
    histograms = np.zeros((1000, 1000, cells.BINS), int)
    rows, columns = np.indices((1000, 1000))
    histograms[rows, columns, rng.integers(cells.BINS, size=(1000, 1000))] = 1
    directed = cells.direct_cells(histograms)
    scene = corridor.make_corridor(walkers=200)
    grid = GridMap.over(scene.area, cell=0.1)
    angles = cells.orientations(scene.traces, grid)
    runs = {
        "placement.vote.1000x1000": lambda: votes.vote(directed),
        "placement.votes.slider": lambda: votes.place_by_votes(None, grid, n=4, angles=angles),
    }
    return [(name, _timed(run)(7)["seconds"], None, None, "s") for name, run in runs.items()]


def time_choices():
    """The proven optimum of 1,200 walker-seconds and 1,500 cameras, against chama's.

    The greedy choice with swaps stands in the next rows: its time, and its share as a
    share of the optimum's.
    """
    served = coverage_instance()
    n = 6
    with _peers() as ask, tempfile.TemporaryDirectory() as folder:
        peer = ask("chama", _save(folder, "served", served=served), n=n)
        rows = _against(
            "coverage.exact-vs-chama", lambda: choice.choose_exact(served, n), peer, rounds=1
        )
    exact, swaps = choice.choose_exact(served, n), choice.choose_with_swaps(served, n)
    seconds = _timed(lambda: choice.choose_with_swaps(served, n))(7)["seconds"]
    return [
        *rows,
        ("coverage.exact.gap", exact.gap, None, None, "share"),
        ("coverage.swaps", seconds, None, None, "s"),
        ("coverage.swaps-of-exact", swaps.share, exact.share, swaps.share / exact.share, "share"),
    ]


def time_foresight():
    """All pairs of a hundred walkers at one time step, by the default forecaster; the benchmark.

    The peer of the first is the obvious baseline, constant velocity.  The second row is the
    whole benchmark on every recording at hand, measuring silhouettes apart.
    """
    casia = recordings.casia_a()
    begin = perf_counter()
    tables = [
        compare_composites(casia),
        compare_crossings(),
        *video_pairs()[0],
    ]
    judge(tables)
    whole = perf_counter() - begin
    model = learn(tables)
    crowd = hundred_walkers()
    ours, peer = _take_turns(
        lambda: model.forecast(crowd),
        lambda: forecasters.ConstantVelocity().forecast(crowd),
        rounds=21,
    )
    return [
        _row("occlusion.hundred-walkers", ours, peer),
        ("occlusion.benchmark", whole, None, None, "s"),
    ]


def hundred_walkers():
    """Every pair of a hundred people in view at one moment of a synthetic square, 4,950."""
    square = crossings.Square(
        frame_width=1920, frame_height=1080, focal_length=1600, height=8, tilt=20, near=12, far=40
    )
    made = crossings.make_crossings(people=200, seconds=4, square=square, seed=3)
    seen = watch(made, int(made.boxes["frame"].median()))
    return replace(seen, who=seen.who[(seen.who < 100).all(axis=1)])


def coverage_instance(targets=1200, cameras=1500):
    """A served matrix of that size: fixed cameras in the corridor, a walker-second a row."""
    scene = corridor.make_corridor(walkers=120)
    model = CameraModel(field_of_view=60, reach=8)
    site = prepare_site(scene, model=model, grid=GridMap.over(scene.area, cell=0.5))
    rng = np.random.default_rng(0)
    rows = np.sort(rng.choice(len(site.targets), targets, replace=False))
    return site.served[np.ix_(rows, np.sort(rng.choice(len(site.cameras), cameras, replace=False)))]


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
    with sample_sequences(most=10_000 if catalogue.casia_a_folder() else 80) as sequences:
        measure_sequences(sequences[:4], n_jobs=2)  # the workers' start is not the measuring
        ours, peer = _take_turns(
            lambda: measure_sequences(sequences, n_jobs=2),
            lambda: measure_sequences(sequences, n_jobs=1),
            rounds=ROUNDS,
        )
    return [_row(f"direction.{len(sequences)}-videos.two-cores-vs-one", ours, peer)]


def time_panels():
    """From a slider's move to the redrawn figure, one row a panel and one over all."""
    casia = recordings.casia_a()
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
    return _time_moves("widgets.direction", moves)


def time_siting_panels():
    """The same for chapter 2."""
    scene = corridor.make_corridor()
    film = overhead.render_corridor(walkers=10, seconds=20)
    (boxes,), truth = viewpoint.record_at_angles(range(0, 91, 15), subjects=1)
    model = CameraModel(pans=True)
    moves = {
        "gait": (widgets.gait_panel(boxes, truth, frame_rate=25.0), "angle", [0, 30, 60, 90] * 4),
        "flow": (widgets.flow_panel(film.frames[100:102]), "alpha", range(3, 19)),
        "vote": (widgets.vote_panel(scene), "chaos_ratio", np.arange(0.2, 1, 0.05)),
        "choice": (widgets.choice_panel(scene, model=model), "n", [1, 2, 4, 5, 6, 7, 8] * 2),
    }
    return _time_moves("widgets.placement", moves)


def time_occlusion_panels():
    """The same for speed and occlusion."""
    made = crossings.make_crossings(people=25, seconds=15)
    seen = find_pairs(made)
    tables = [compare_crossings(), compare_composites(recordings.casia_a())]
    judged = judge(tables, draws=20)
    speeds = {"PETS 2009": outdoors.apparent_speeds("pets")}
    moves = {
        "speed": (widgets.speed_panel(speeds), "slow", np.arange(0.25, 4.0, 0.25)),
        "table": (widgets.occlusion_panel(), "seconds", np.arange(0.2, 3.0, 0.2)),
        "threshold": (widgets.threshold_panel(judged), "threshold", np.arange(0.1, 0.9, 0.05)),
        "rules": (widgets.rules_panel(), "horizon", [1.5, 2.0, 2.5, 3.5, 4.0] * 3),
        "pair": (widgets.pair_panel(made, seen), "seconds", np.arange(-0.8, 2.8, 0.2)),
    }
    return _time_moves("widgets.occlusion", moves)


def _time_moves(name, moves):
    """Seconds from a move to the new picture: the median over all, and of each panel."""
    rows, every = [], []
    for panel_name, (panel, control, values) in moves.items():
        seconds = []
        for value in values:
            begin = perf_counter()
            panel.controls[control].value = value
            seconds.append(perf_counter() - begin)
        every += seconds
        rows.append((f"{name}.{panel_name}", float(np.median(seconds)), None, None, "s"))
    return [(name, float(np.median(every)), None, None, "s"), *rows]


@contextmanager
def _peers():
    """ask(task, file, **options) → a peer as `_against` takes it; None without peers.

    A peer that dies raises `McnError` with the last that it said.
    """
    python = os.environ.get(PEERS)
    if not python:
        yield lambda *_, **__: None
        return
    alone = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    # What it says goes to a file: nobody reads a pipe, and a full one would stop it.
    with tempfile.TemporaryFile("w+", errors="replace") as said:
        try:
            worker = subprocess.Popen(
                [python, "-P", peers.__file__],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
                env=alone,
            )
        except OSError as fault:
            raise McnError(
                f"{PEERS} is {python!r}, which cannot be run ({fault.strerror}); name the Python "
                "of the peers' environment."
            ) from fault

        def ask(task, data, **options):
            request = json.dumps({"task": task, "data": str(data), **options}) + "\n"

            def run(_rounds=1):
                try:
                    worker.stdin.write(request)
                    worker.stdin.flush()
                    return json.loads(worker.stdout.readline())
                except (OSError, ValueError) as fault:
                    raise McnError(_last_words(task, worker, said)) from fault

            return run

        try:
            yield ask
        finally:
            with suppress(OSError):  # what a dead worker never read
                worker.stdin.close()
            worker.wait()
            worker.stdout.close()


def _last_words(task, worker, said):
    """Why a peer gave no answer."""
    with suppress(OSError):
        worker.stdin.close()
    code = worker.wait()
    said.seek(0)
    lines = said.read().split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "nothing")
    return (
        f"the peer for {task!r} ended with code {code} and gave no answer; the last that it said: "
        f"{last.strip()!r}. Mend the environment that {PEERS} names (peers.txt)."
    )


def _timed(run, *, truth=None):
    """run as a peer: the median of some rounds, and the end-point error of a flow."""

    def measure(rounds=1):
        seconds = []
        for _ in range(rounds):
            begin = perf_counter()
            result = run()
            seconds.append(perf_counter() - begin)
        held = {"seconds": float(np.median(seconds))}
        return held if truth is None else {**held, "epe": flow.end_point_error(result, truth)}

    return measure


def _against(name, ours, peer, *, truth=None, rounds=ROUNDS):
    """Rows of ours against a peer that take turns: seconds, and errors if there is a truth."""
    ours = _timed(ours, truth=truth)
    cv2.setNumThreads(1)
    try:
        ours()  # a warm-up each
        if peer is not None:
            peer()
        pairs = [(ours(), peer() if peer is not None else None) for _ in range(rounds)]
    finally:
        cv2.setNumThreads(-1)
    mine = float(np.median([one["seconds"] for one, _ in pairs]))
    if peer is None:
        return [(name, mine, None, None, "s")]
    theirs = float(np.median([other["seconds"] for _, other in pairs]))
    ratio = float(np.median([one["seconds"] / other["seconds"] for one, other in pairs]))
    rows = [(name, mine, theirs, ratio, "s")]
    one, other = pairs[-1]
    for key, unit in (("epe", "px"), ("share", "share")):
        if key in one and key in other:
            rows.append((f"{name}.{key}", one[key], other[key], one[key] / other[key], unit))
    return rows


def _save(folder, name, **arrays):
    path = Path(folder) / f"{name}.npz"
    np.savez(path, **arrays)
    return path


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
