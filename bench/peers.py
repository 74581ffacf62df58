"""What others' libraries do with the same data, for ``make bench``.

Runs in an environment of its own (``peers.txt``), where there is no mcnlab: reads one request
a line, ``{"task": name, "data": npz file, …}``, and answers each with a line of JSON that
holds at least ``seconds``.  Reading the file is not in the time.
"""

import json
import sys
from time import perf_counter

import numpy as np


def pyoptflow(data, *, alpha, iterations):
    """Horn and Schunck by pyoptflow; saves the flow beside the data."""
    from pyoptflow import HornSchunck

    return _time_flow(
        data, lambda first, second: HornSchunck(first, second, alpha=alpha, Niter=iterations)
    )


def tv_l1(data):
    """TV-L1 by scikit-image; its flow is (rows, columns)."""
    from skimage.registration import optical_flow_tvl1

    return _time_flow(data, lambda first, second: optical_flow_tvl1(first, second)[::-1])


def ilk(data):
    """Iterative Lucas–Kanade by scikit-image; its flow is (rows, columns)."""
    from skimage.registration import optical_flow_ilk

    return _time_flow(data, lambda first, second: optical_flow_ilk(first, second)[::-1])


def chama(data, *, n):
    """Maximal coverage by chama with HiGHS: model and solution."""
    import pandas as pd
    from chama.optimize import CoverageFormulation

    served = data["served"]
    sensors = pd.DataFrame(
        {
            "Sensor": [f"c{camera}" for camera in range(served.shape[1])],
            "Coverage": [
                [f"t{target}" for target in np.flatnonzero(column)] for column in served.T
            ],
        }
    )
    sensors = sensors[sensors["Coverage"].str.len() > 0].reset_index(drop=True).astype(object)
    targets = [f"t{target}" for target in np.flatnonzero(served.any(axis=1))]
    begin = perf_counter()
    found = CoverageFormulation().solve(
        coverage=sensors,
        entity=pd.DataFrame({"Entity": targets}).astype(object),
        sensor_budget=n,
        mip_solver_name="highs",
        solver_options={"mip_rel_gap": 0.0, "mip_abs_gap": 0.99},
    )
    seconds = perf_counter() - begin
    chosen = [int(name[1:]) for name in found["Sensors"]]
    return {"seconds": seconds, "share": float(served[:, chosen].any(axis=1).mean())}


def _time_flow(data, find):
    first, second, truth = data["first"], data["second"], data["truth"]
    begin = perf_counter()
    u, v = find(first, second)
    seconds = perf_counter() - begin
    return {
        "seconds": seconds,
        "epe": float(np.hypot(u - truth[..., 0], v - truth[..., 1]).mean()),
    }


TASKS = {"pyoptflow": pyoptflow, "tv-l1": tv_l1, "ilk": ilk, "chama": chama}


def main():
    """Answer requests until there are no more."""
    answers, sys.stdout = sys.stdout, sys.stderr  # what a library prints is no answer
    for line in sys.stdin:
        request = json.loads(line)
        task = TASKS[request.pop("task")]
        with np.load(request.pop("data")) as held:
            data = dict(held)
        print(json.dumps(task(data, **request)), file=answers, flush=True)


if __name__ == "__main__":
    main()
