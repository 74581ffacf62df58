"""python -m bench: time mcnlab against its peers and write ``bench.csv``."""

import argparse
import sys

from bench.run import bench
from mcnlab.errors import McnError


def main(arguments=None):
    """Run every benchmark; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--out", default="build", help="where bench.csv goes (default: build)")
    chosen = parser.parse_args(arguments)
    try:
        print(f"Done. The figures are in {bench(chosen.out)}.")
    except McnError as fault:
        print(f"bench: {fault}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
