"""The panel of section 3.2.2: thresholds and window of the speed levels."""

import numpy as np

from mcnlab import plotting
from mcnlab.pace import misordered
from mcnlab.speed import FAST, LEVELS, NAMES, SECONDS, SLOW, level_of
from mcnlab.widgets.panel import Panel, choices, decimal_slider


def speed_panel(tables):
    """Thresholds and window length over windows by distance, and true speed by level.

    Parameters
    ----------
    tables : dict
        Title → table of `pace.compare_speeds`, with windows of one second and, if the
        first has them, of other lengths.
    """
    titles = list(tables)
    lengths = sorted(tables[titles[0]]["seconds"].unique())
    held = {
        (title, length): table[table["seconds"] == length]
        for title, table in tables.items()
        for length in lengths
    }

    def draw(left, right, where, seconds, slow, fast):
        table = held[where, seconds]
        right.set_xticks([])  # nothing is said of the levels if the thresholds are refused
        level = level_of(table["share"], frame_width=1, slow=slow / 100, fast=fast / 100)
        plotting.plot_by_distance(
            table["distance"],
            100 * table["share"],
            level,
            ylabel="p (% of the frame's width)",
            cuts=(slow, fast),
            legend=False,  # the right-hand picture names the levels
            ax=left,
        )
        speed = table["true_speed"].to_numpy()
        plotting.plot_by_level(speed, level, ax=right)
        said = ", ".join(
            f"{NAMES[one]} <b>{np.median(speed[level == one]):.2f} m/s</b>"
            if (level == one).any()
            else f"{NAMES[one]} <b>no window</b>"
            for one in LEVELS
        )
        # No interval: it would cost more than the rest.
        wrong = misordered(speed, level, table["sequence"], draws=1)
        overlap = "" if wrong is None else f"; v2 truly faster than v3: <b>{wrong.value:.0%}</b>"
        return f"{len(table)} windows; median {said}{overlap}"

    return Panel(
        draw,
        {
            "where": choices("walkers", titles),
            "seconds": choices(
                "window", [(f"{length:g} s", length) for length in lengths], value=SECONDS
            ),
            "slow": decimal_slider("slow: v1 up to (%)", 0, 10, 100 * SLOW, step=0.25),
            "fast": decimal_slider("fast: v2 up to (%)", 0, 20, 100 * FAST, step=0.25),
        },
        columns=2,
        figsize=(10, 4),
        margins={"left": 0.08, "wspace": 0.25},
    )
