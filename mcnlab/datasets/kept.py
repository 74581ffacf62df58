"""The tables that come with mcnlab: measured anew or read, written, and checked.

`Kept` is the one rule of which it is: recordings that lie under ``MCNLAB_DATA`` are measured,
and where they do not, the bundled tables are read.  Each of those lies beside a note of where
it comes from: dataset, credit, command, version and checksums.  Recordings themselves are not
handed on.
"""

import gzip
import hashlib
import json
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

import mcnlab
from mcnlab.datasets.catalogue import BUNDLED, data_folder, read_table
from mcnlab.datasets.reading import reading
from mcnlab.errors import DatasetError
from mcnlab.files import write_whole


@dataclass(frozen=True)
class Kept:
    """Tables that are measured where their recordings are at hand, and else as bundled.

    Attributes
    ----------
    folder : str
        Where the bundled tables lie under ``data/``.
    names : tuple of str
        The tables, without ``.csv.gz``.
    files : callable
        Data folder → the recordings' paths in it; all are needed.
    measure : callable
        Data folder → the table, or a tuple of tables in the order of `names`.
    text : tuple of str
        Columns that hold text, even where it looks like numbers.
    """

    folder: str
    names: tuple[str, ...]
    files: Callable[[Path], Iterable[Path]]
    measure: Callable[..., Any]
    text: tuple[str, ...] = ()

    def lies_in(self, folder: str | os.PathLike) -> bool:
        """Whether a data folder holds all the recordings."""
        return all(path.exists() for path in self.files(Path(folder)))

    def at_hand(self) -> Path | None:
        """The folder that ``MCNLAB_DATA`` names, if all the recordings lie there, or None."""
        folder = data_folder()
        return folder if folder is not None and self.lies_in(folder) else None

    def bundled(self) -> tuple[pd.DataFrame, ...]:
        """The tables that came with mcnlab."""
        types = dict.fromkeys(self.text, str)
        paths = (BUNDLED / self.folder / f"{name}.csv.gz" for name in self.names)
        return tuple(read_table(path, dtype=types) for path in paths)

    def measured(self, folder: Path, **options: Any) -> tuple[pd.DataFrame, ...]:
        """The tables of the recordings in a data folder."""
        tables = self.measure(folder, **options)
        return tables if isinstance(tables, tuple) else (tables,)

    def tables(self, **options: Any) -> tuple[pd.DataFrame, ...]:
        """Measured or bundled; `options` are for measuring."""
        folder = self.at_hand()
        return self.bundled() if folder is None else self.measured(folder, **options)


def check_bundled(folder: str | os.PathLike = BUNDLED) -> pd.DataFrame:
    """One row a bundled table: its rows and whether it is the one that was measured.

    Returns
    -------
    pandas.DataFrame
        ``table, rows, dataset, sound``.

    Raises
    ------
    DatasetError
        When a provenance note is missing or cannot be read.
    """
    rows = []
    for note in sorted(Path(folder).glob("*/provenance.json")):
        with reading(note, "a provenance note"):
            held = json.loads(note.read_text())
            facts = [
                (name, held["dataset"], fact["rows"], fact["sha256"])
                for name, fact in held["tables"].items()
            ]
        for name, dataset, count, checksum in facts:
            path = note.parent / name
            with reading(path, "a packed table"):
                content = gzip.decompress(path.read_bytes())
            rows.append(
                {
                    "table": f"{note.parent.name}/{name}",
                    "rows": count,
                    "dataset": dataset,
                    "sound": _sha256(content) == checksum,
                }
            )
    if not rows:
        raise DatasetError(f"folder {str(folder)!r} holds no provenance note; restore data/.")
    return pd.DataFrame(rows)


def write_tables(folder: Path, tables: dict[str, pd.DataFrame], facts: dict) -> list[Path]:
    """Write tables and their note of provenance; the files written come back.

    Parameters
    ----------
    folder : pathlib.Path
    tables : dict
        File name → table.
    facts : dict
        For the note: ``dataset``, ``credit`` and whatever else is known.
    """
    written, notes = [], {}
    for name, table in tables.items():
        content = table.to_csv(index=False, lineterminator="\n").encode()
        notes[name] = {"rows": len(table), "sha256": _sha256(content)}
        # mtime 0: the same table gives the same bytes.
        written.append(write_whole(folder / name, gzip.compress(content, 9, mtime=0)))
    note = {
        **facts,
        "command": "python -m mcnlab measure",
        "version": f"mcnlab {mcnlab.__version__}",
        "tables": notes,
    }
    text = json.dumps(note, indent=2, ensure_ascii=False) + "\n"
    written.append(write_whole(folder / "provenance.json", text))
    return written


def _sha256(content):
    return hashlib.sha256(content).hexdigest()
