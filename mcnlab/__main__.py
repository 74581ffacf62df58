"""python -m mcnlab reproduce | measure | data | refresh"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from mcnlab.errors import McnError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return its exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m mcnlab", description="The executable thesis, from the command line."
    )
    commands = parser.add_subparsers(dest="command", required=True)

    reproduce = commands.add_parser("reproduce", help="re-run the notebooks and write the report")
    reproduce.add_argument(
        "--data", help="folder of recordings (default: $MCNLAB_DATA, or bundled)"
    )
    reproduce.add_argument("--out", default="build", help="where results go (default: build)")
    reproduce.add_argument("--only", help="one notebook's name, or a part of it")

    measure = commands.add_parser("measure", help="measure recordings into the bundled tables")
    measure.add_argument("--data", help="folder of recordings (default: $MCNLAB_DATA)")
    measure.add_argument("--out", default="data", help="where the tables go (default: data)")

    commands.add_parser("data", help="list the bundled tables and check them")

    refresh = commands.add_parser("refresh", help="re-run the notebooks in place")
    refresh.add_argument("--only", help="one notebook's name, or a part of it")

    chosen = parser.parse_args(arguments)
    if getattr(chosen, "data", None):
        os.environ["MCNLAB_DATA"] = str(Path(chosen.data).resolve())
    try:
        return _COMMANDS[chosen.command](chosen)
    except McnError as fault:
        print(f"mcnlab: {fault}", file=sys.stderr)
        return 2


def _reproduce(chosen):
    from mcnlab.lab.reproduction import reproduce

    page = reproduce(chosen.out, only=chosen.only)
    print(f"Done. Open {page} in a browser.")
    return 0


def _measure(chosen):
    from mcnlab.datasets import catalogue
    from mcnlab.errors import DatasetError
    from mcnlab.lab.measure import measure_all

    folder = catalogue.data_folder()
    if folder is None:
        raise DatasetError("no folder of recordings; pass --data or set MCNLAB_DATA.")
    for path in measure_all(folder, chosen.out, progress=True):
        print(path)
    return 0


def _data(chosen):
    from mcnlab.datasets import catalogue, kept

    table = kept.check_bundled()
    print(table.to_string(index=False))
    folder = catalogue.data_folder()
    print(f"MCNLAB_DATA: {folder if folder else 'not set; the tables above are used'}")
    return 0 if table["sound"].all() else 1


def _refresh(chosen):
    from mcnlab.lab.reproduction import refresh

    refresh(only=chosen.only)
    return 0


_COMMANDS = {
    "reproduce": _reproduce,
    "measure": _measure,
    "data": _data,
    "refresh": _refresh,
}


if __name__ == "__main__":
    sys.exit(main())
