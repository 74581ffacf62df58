"""Writes the tables that come with mcnlab, and checks them: ``python -m mcnlab measure | data``.

Each table lies beside a note of where it comes from: dataset, credit, command, version and
checksums.  Recordings themselves are not handed on.
"""

import gzip
import hashlib
import json
import zlib
from pathlib import Path

import pandas as pd

import mcnlab
from mcnlab.datasets.catalogue import BUNDLED
from mcnlab.errors import DatasetError
from mcnlab.files import write_whole


def check_bundled(folder=BUNDLED):
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
        try:
            held = json.loads(note.read_text())
            facts = [
                (name, held["dataset"], fact["rows"], fact["sha256"])
                for name, fact in held["tables"].items()
            ]
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as fault:
            raise DatasetError(f"{note} is not a provenance note ({fault}); restore it.") from fault
        for name, dataset, count, checksum in facts:
            try:
                content = gzip.decompress((note.parent / name).read_bytes())
            except (OSError, EOFError, zlib.error) as fault:
                raise DatasetError(
                    f"{note.parent.name}/{name} cannot be read ({fault}); restore it."
                ) from fault
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


def _write_tables(folder, tables, facts):
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
