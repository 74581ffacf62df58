"""Where data lie, and how their tables are read."""

import gzip
import os
import subprocess
import sys

import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mcnlab.__main__ import main
from mcnlab.datasets import catalogue
from mcnlab.errors import DatasetError, McnError
from mcnlab.vision import recordings
from mcnlab.walking import outdoors


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """scratch(data): a file that holds `data`, the same place each time."""
    path = tmp_path_factory.mktemp("scratch") / "boxes.csv.gz"

    def write(data):
        path.write_bytes(data)
        return path

    return write


def test_the_data_folder_is_what_the_variable_names(tmp_path, monkeypatch):
    assert catalogue.data_folder() is None
    monkeypatch.setenv("MCNLAB_DATA", str(tmp_path))
    assert catalogue.data_folder() == tmp_path
    assert catalogue.casia_a_folder() is None  # nothing lies there, so the bundled table stands in
    assert len(recordings.casia_a(mirrored=False).sequences) == 168
    assert len(outdoors.pets2009_headings()) == 653
    for wrong in (tmp_path / "gone", tmp_path / "file"):
        (tmp_path / "file").touch()
        monkeypatch.setenv("MCNLAB_DATA", str(wrong))
        with pytest.raises(DatasetError, match=r"MCNLAB_DATA is .* not a folder"):
            recordings.casia_a()


WHOLE = gzip.compress(b"sequence,frame\n" + b"walk,1\nwalk,2\n" * 40, mtime=0)


def test_a_table_that_is_missing_or_a_folder_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="is missing"):
        catalogue.read_table(tmp_path / "boxes.csv")
    with pytest.raises(DatasetError, match="is not a table"):
        catalogue.read_table(tmp_path)


def test_no_damage_to_a_packed_table_goes_unseen(scratch):
    whole = catalogue.read_table(scratch(WHOLE))
    assert len(whole) == 80
    for length in range(len(WHOLE)):
        with pytest.raises(DatasetError, match="is not a table"):
            catalogue.read_table(scratch(WHOLE[:length]))
    for at in range(len(WHOLE)):
        damaged = bytearray(WHOLE)
        damaged[at] ^= 0xFF
        try:
            table = catalogue.read_table(scratch(bytes(damaged)))
        except DatasetError:
            continue
        # Ten bytes of header carry a time and a system, which say nothing of the table.
        assert at < 10
        assert table.equals(whole)


@given(st.one_of(st.binary(max_size=200), st.binary(max_size=100).map(gzip.compress)))
@settings(max_examples=200)
@example(gzip.compress(b"a,b\n1,2\n3,4,5,6\n"))
def test_any_bytes_are_a_table_or_a_clear_error(scratch, data):
    try:
        table = catalogue.read_table(scratch(data))
    except McnError:
        return
    assert isinstance(table, pd.DataFrame)


def test_the_command_line_lists_the_bundled_tables():
    inherited = {name: value for name, value in os.environ.items() if name != "MCNLAB_DATA"}
    run = subprocess.run(
        [sys.executable, "-m", "mcnlab", "data"],
        capture_output=True,
        text=True,
        env=inherited,
        cwd=catalogue.BUNDLED.parent,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert "casia-a/boxes.csv.gz" in run.stdout
    assert "MCNLAB_DATA: not set" in run.stdout


def test_the_command_line_says_what_is_wrong_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("MCNLAB_DATA", str(tmp_path / "gone"))
    assert main(["data"]) == 2
    held = capsys.readouterr()
    assert held.err.startswith("mcnlab: MCNLAB_DATA is ")
    assert len(held.err.splitlines()) == 1
