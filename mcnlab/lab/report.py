"""The report of a reproduction: one page, thesis figure by thesis figure."""

from html import escape
from pathlib import Path

import mcnlab
from mcnlab.figures.registry import FIGURES, NOTEBOOKS
from mcnlab.results import SECONDS, verdict_of

_STYLE = """
:root { --ink: #1c2430; --quiet: #5d6673; --line: #e1e5ea; --blue: #1d5fa8; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #f6f7f9;
  font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
header { background: #14213d; color: white; padding: 3rem 1.5rem 2.4rem; }
header > div, main { max-width: 70rem; margin: 0 auto; }
header p { max-width: 46rem; color: #d5dbe6; margin: .4rem 0 0; }
h1 { margin: 0; font-size: 2rem; } h2 { margin: 2.6rem 0 .8rem; font-size: 1.35rem; }
main { padding: 0 1.5rem 4rem; }
article { background: white; border: 1px solid var(--line); border-radius: 10px;
  padding: 1.2rem 1.4rem; margin: 1.1rem 0; }
article h3 { margin: 0 0 .1rem; font-size: 1.1rem; }
article h3 b { color: var(--blue); margin-right: .5rem; }
article img { display: block; max-width: 100%; max-height: 38rem; margin: .9rem auto; }
.where { color: var(--quiet); font-size: .85rem; margin: 0; }
dl { display: grid; grid-template-columns: 5.5rem 1fr; gap: .3rem .8rem; margin: .4rem 0 0; }
dt { color: var(--quiet); } dd { margin: 0; }
table { border-collapse: collapse; width: 100%; background: white; font-size: .92rem; }
th, td { text-align: left; padding: .4rem .7rem; border-bottom: 1px solid var(--line); }
th { color: var(--quiet); font-weight: 600; } td.n { text-align: right;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
th.n { text-align: right; } code { font-size: .88em; } td code { white-space: nowrap; }
summary { cursor: pointer; margin: 1rem 0; color: var(--blue); }
.scroll { overflow-x: auto; border: 1px solid var(--line); border-radius: 10px; }
.mark { border-radius: 99px; padding: .05rem .6rem; font-size: .82rem; white-space: nowrap; }
.holds { background: #dff3ea; color: #14573f; } .fails { background: #fbe3e5; color: #86202e; }
.beyond { background: #e4edf8; color: #174a84; }
"""

_VERDICTS = {
    "holds": "holds",
    "exceeded": "holds",
    "below the claim": "fails",
    "faster": "holds",
    "slower": "fails",
    "other data": "beyond",
    "no claim": "beyond",
}


def render(table, out):
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
    rows = {row["id"]: row for row in table.to_dict("records")}
    shown = [entry for entry in FIGURES.values() if (Path(out) / "figures" / entry.file).is_file()]
    thesis = sorted(
        (entry for entry in shown if entry.section),
        key=lambda entry: entry.place,
    )
    beyond = sorted(
        (entry for entry in shown if not entry.section),
        key=lambda entry: NOTEBOOKS.index(entry.notebook),
    )
    timings = [row for row in rows.values() if row["unit"] == SECONDS]
    numbers = [row for row in rows.values() if row["unit"] != SECONDS]
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<title>The executable thesis</title><style>{_STYLE}</style></head><body>",
        "<header><div><h1>The executable thesis</h1>",
        "<p>R. Raman, <i>Study on Models for Smart Surveillance through Multi-Camera "
        "Networks</i>, NIT Rourkela, 2013: re-run, measured on real people, and taken further. "
        f"Made by mcnlab {mcnlab.__version__}; every number below comes from a notebook of "
        "this run.</p></div></header><main>",
        "<h2>What the thesis claims in numbers</h2>",
        _numbers([row for row in numbers if row["thesis"]]),
        "<details><summary>All numbers of this run</summary>",
        _numbers(numbers),
        "</details>",
        "<h2>The thesis, figure by figure</h2>",
        *(_article(entry, rows) for entry in thesis),
        "<h2>Beyond the thesis</h2>",
        *(_article(entry, rows) for entry in beyond),
    ]
    if timings:
        parts += ["<h2>Timings</h2>", _numbers(timings)]
    parts.append("</main></body></html>\n")
    return "\n".join(parts)


def _article(entry, rows):
    number = entry.label
    where = " · ".join(
        [f"section {entry.section}"] * bool(entry.section)
        + [f"<a href='notebooks/{entry.notebook}.ipynb'>{entry.notebook}</a>"]
    )
    claim = "Claim" if entry.section else "Question"
    found = [escape(entry.finding)] * bool(entry.finding)
    found += [_sentence(rows[name]) for name in entry.ids if name in rows]
    alternative = escape(f"{number}: {entry.title}", quote=True)
    return (
        f"<article id='{entry.number}'><h3><b>{number}</b>{escape(entry.title)}</h3>"
        f"<p class='where'>{where}</p>"
        f"<img src='figures/{entry.file}' alt='{alternative}'>"
        f"<dl><dt>{claim}</dt><dd>{escape(entry.claim)}</dd>"
        f"<dt>Here</dt><dd>{'<br>'.join(found)}</dd></dl></article>"
    )


def _sentence(row):
    interval = f" [{row['low']}, {row['high']}]" if row["low"] else ""
    unit = f" {escape(row['unit'])}" if row["unit"] else ""
    return f"<code>{escape(row['id'])}</code> {row['here']}{unit}{interval} {_mark(row)}"


def _mark(row):
    verdict = verdict_of(row)
    if verdict == "no claim":
        return ""
    return f"<span class='mark {_VERDICTS[verdict]}'>{verdict}: thesis {row['thesis']}</span>"


def _numbers(rows):
    lines = []
    for row in rows:
        interval = f"{row['low']} to {row['high']}" if row["low"] else ""
        verdict = verdict_of(row)
        lines.append(
            f"<tr><td><code>{escape(row['id'])}</code></td><td class='n'>{row['thesis']}</td>"
            f"<td class='n'>{row['here']} {escape(row['unit'])}</td><td class='n'>{interval}</td>"
            f"<td class='n'>{row['n']}</td><td>{escape(row['data'])}</td>"
            f"<td><span class='mark {_VERDICTS[verdict]}'>{verdict}</span></td></tr>"
        )
    return (
        "<div class='scroll'><table><tr><th>quantity</th><th class='n'>thesis</th>"
        "<th class='n'>here</th><th class='n'>95 % interval</th><th class='n'>n</th>"
        f"<th>data</th><th>verdict</th></tr>{''.join(lines)}</table></div>"
    )
