"""The report of a reproduction: one page, thesis figure by thesis figure."""

import os
from pathlib import Path

import pandas as pd

import mcnlab
from mcnlab.figures.registry import FIGURES, NOTEBOOKS
from mcnlab.results import SECONDS, verdict_of

TEMPLATE = "report.html.j2"  # beside this module
_MARKS = {
    "holds": "holds",
    "exceeded": "holds",
    "below the claim": "fails",
    "faster": "holds",
    "slower": "fails",
    "other data": "beyond",
    "no claim": "beyond",
}


def render(table: pd.DataFrame, out: str | os.PathLike) -> str:
    """The page.

    Parameters
    ----------
    table : pandas.DataFrame
        Result rows, text.
    out : path-like
        The folder that holds ``figures/``.

    Returns
    -------
    str
        HTML.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    said = [{**row, "verdict": verdict_of(row)} for row in table.to_dict("records")]
    rows = {row["id"]: row for row in said}
    shown = [entry for entry in FIGURES.values() if (Path(out) / "figures" / entry.file).is_file()]
    pages = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined
    )
    return pages.get_template(TEMPLATE).render(
        version=mcnlab.__version__,
        rows=rows,
        marks=_MARKS,
        measured=[row for row in rows.values() if row["unit"] != SECONDS],
        timings=[row for row in rows.values() if row["unit"] == SECONDS],
        thesis=sorted((one for one in shown if one.section), key=lambda one: one.place),
        beyond=sorted(
            (one for one in shown if not one.section),
            key=lambda one: NOTEBOOKS.index(one.notebook),
        ),
    )
