"""Re-running the notebooks: for a report, or to refresh what they show."""

import os
from pathlib import Path
from typing import Any

import pandas as pd

from mcnlab.datasets.catalogue import data_folder
from mcnlab.errors import ArgumentError, McnError
from mcnlab.figures.registry import FIGURES, NOTEBOOKS
from mcnlab.files import write_whole
from mcnlab.lab import report
from mcnlab.results import COLUMNS, OUT, SECONDS

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
CELL_TIMEOUT = 600  # s


class NotebookError(McnError):
    """A notebook did not run to its end."""


def choose_notebooks(only: str | None = None) -> list[str]:
    """The notebooks' names in reading order, all or those whose name contains `only`.

    Raises
    ------
    ArgumentError
        When no name contains `only`.
    """
    names = [name for name in NOTEBOOKS if not only or only in name]
    if not names:
        raise ArgumentError(f"only is {only!r}; pass a part of one of {', '.join(NOTEBOOKS)}.")
    return names


def reproduce(out: str | os.PathLike, *, only: str | None = None, n_jobs: int = -1) -> Path:
    """Run the notebooks and write their numbers, figures and a report.

    Parameters
    ----------
    out : path-like
        Gets ``results.csv``, ``timings.csv``, ``figures/``, ``notebooks/`` and
        ``index.html``, each file whole or not at all.
    only : str, optional
        A part of a notebook's name.
    n_jobs : int, optional
        Notebooks at a time, as joblib counts.

    Returns
    -------
    pathlib.Path
        The report.

    Raises
    ------
    McnError
        When a notebook fails; what it says is in the message.
    """
    from joblib import Parallel, delayed
    from tqdm.auto import tqdm

    names = choose_notebooks(only)
    out = Path(out).resolve()
    if out / "notebooks" == FOLDER:
        raise ArgumentError(f"out is {str(out)!r}, which holds the notebooks; pass another folder.")
    rows = out / "rows"
    # What an earlier run left must not pass for this one's.
    for stale in (
        *(rows / f"{name}.csv" for name in NOTEBOOKS),
        *(out / "notebooks" / f"{name}.ipynb" for name in NOTEBOOKS),
        *(out / "figures" / entry.file for entry in FIGURES.values()),
        *(out / name for name in ("results.csv", "timings.csv", "index.html")),
    ):
        stale.unlink(missing_ok=True)
    data_folder()  # one that is not there is said now, not by every notebook
    # The workers may be old: they get the environment of today.
    environment = {**os.environ, OUT: str(out)}
    jobs = Parallel(n_jobs=n_jobs, return_as="generator")(
        delayed(_run_into)(name, out, environment) for name in names
    )
    faults = [
        fault
        for fault in tqdm(jobs, total=len(names), desc="notebooks", unit="notebook")
        if fault is not None
    ]
    names = [name for name in names if (rows / f"{name}.csv").is_file()]
    if not names:
        raise NotebookError(faults[0])
    tables = [pd.read_csv(rows / f"{name}.csv", dtype=str, na_filter=False) for name in names]
    table = pd.concat(tables, ignore_index=True)[list(COLUMNS)]
    timing = table["unit"] == SECONDS
    for file, part in (("results.csv", table[~timing]), ("timings.csv", table[timing])):
        write_whole(out / file, part.to_csv(index=False, lineterminator="\n"))
    for name in names:
        (rows / f"{name}.csv").unlink()
    rows.rmdir()
    page = write_whole(out / "index.html", report.render(table, out))
    if faults:
        raise NotebookError(" ".join(faults) + f" What the others gave is in {page}.")
    return page


def refresh(*, only: str | None = None) -> None:
    """Run the notebooks in place, keep outputs and counts, drop what changes by itself."""
    from tqdm.auto import tqdm

    os.environ.pop("MCNLAB_DATA", None)
    for name in tqdm(choose_notebooks(only), desc="notebooks", unit="notebook"):
        path = FOLDER / f"{name}.ipynb"
        write_whole(path, _as_text(_clean(run_notebook(path))))


def run_notebook(path: str | os.PathLike, *, environment: dict[str, str] | None = None) -> Any:
    """Run one notebook and return it with its outputs.

    Parameters
    ----------
    path : path-like
    environment : dict, optional
        The environment of its kernel; this process's if not given.

    Raises
    ------
    NotebookError
        When a cell raises; the message names the notebook and ends with the error.
    """
    import nbformat
    from nbclient import NotebookClient
    from nbclient.exceptions import CellExecutionError, CellTimeoutError

    path = Path(path)
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        timeout=CELL_TIMEOUT,
        kernel_name="python3",
        record_timing=False,
        store_widget_state=False,
        extra_arguments=["--log-level=ERROR"],
        resources={"metadata": {"path": str(path.parent)}},
    )
    try:
        client.execute(env={**os.environ} if environment is None else environment)
    except CellExecutionError as fault:
        raise NotebookError(
            f"notebook {path.stem} stopped with {fault.ename}: {fault.evalue} "
            "Open it in JupyterLab to see where."
        ) from fault
    except CellTimeoutError as fault:
        raise NotebookError(
            f"notebook {path.stem} has a cell that ran for over {CELL_TIMEOUT} s; "
            "run it in JupyterLab."
        ) from fault
    return notebook


def _run_into(name, out, environment):
    """Run one notebook for a report; return what went wrong, or None."""
    try:
        notebook = run_notebook(FOLDER / f"{name}.ipynb", environment=environment)
    except NotebookError as fault:
        return str(fault)
    write_whole(out / "notebooks" / f"{name}.ipynb", _as_text(notebook))
    return None


def _as_text(notebook):
    import nbformat

    return nbformat.writes(notebook) + "\n"


def _clean(notebook):
    """Drop what differs from run to run or machine to machine."""
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}
    }
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number}"
        cell.metadata = {key: value for key, value in cell.metadata.items() if key == "tags"}
        for result in cell.get("outputs", []):
            # A live widget needs a kernel; its picture stays for those who only read.
            data = result.get("data", {})
            if data.pop("application/vnd.jupyter.widget-view+json", None) is not None:
                data["text/plain"] = "Run this cell to move the sliders."
            result.pop("execution_count", None)
            if result.output_type == "execute_result":
                result["execution_count"] = cell.execution_count
    return notebook
