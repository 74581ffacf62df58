"""Files that are written whole or not at all."""

import hashlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from mcnlab.errors import DatasetError


def write_whole(path: str | os.PathLike, data: bytes | str) -> Path:
    """Write bytes or text to `path` by way of a neighbour that takes its place.

    An interrupted run leaves the old file, or none; never half of the new one.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(data, str):
        data = data.encode()
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return path


def sha256_of(paths: Iterable[str | os.PathLike], *, root: str | os.PathLike | None = None) -> str:
    """The SHA-256 of files, in the order given, each preceded by its name.

    Parameters
    ----------
    paths : iterable of path-like
    root : path-like, optional
        Names are taken relative to this folder; the bare file name if not given.

    Raises
    ------
    DatasetError
        When a file cannot be read.
    """
    digest = hashlib.sha256()
    for path in map(Path, paths):
        name = path.relative_to(root).as_posix() if root else path.name
        try:
            content = path.read_bytes()
        except OSError as fault:
            raise DatasetError(f"{path} cannot be read ({fault.strerror}); restore it.") from fault
        digest.update(name.encode() + b"\0" + content)
    return digest.hexdigest()
