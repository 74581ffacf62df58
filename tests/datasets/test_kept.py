"""The tables that come with mcnlab: whether they are those that were measured."""

import gzip
import json

import pandas as pd
import pytest

from mcnlab.__main__ import main
from mcnlab.datasets import catalogue, kept
from mcnlab.errors import DatasetError


def test_the_bundled_tables_are_those_that_were_measured():
    table = kept.check_bundled()
    assert set(table["table"]) == {
        "casia-a/boxes.csv.gz",
        *(f"pets2009/{name}.csv.gz" for name in ("headings", "speeds", "traces", "feet")),
        "tud-stadtmitte/speeds.csv.gz",
        "motchallenge/pairs.csv.gz",
    }
    assert table["sound"].all()
    for row in table.itertuples():
        assert row.rows == len(pd.read_csv(catalogue.BUNDLED / row.table))


WHOLE = gzip.compress(b"sequence,frame\n" + b"walk,1\nwalk,2\n" * 40, mtime=0)


@pytest.fixture
def note(tmp_path):
    """note(table, **facts): a folder with a provenance note for `table`."""

    def write(table=WHOLE, **facts):
        folder = tmp_path / "casia-a"
        folder.mkdir()
        if table is not None:
            (folder / "boxes.csv.gz").write_bytes(table)
        held = {"dataset": "made up", "tables": {"boxes.csv.gz": {"rows": 80, "sha256": "0"}}}
        (folder / "provenance.json").write_text(json.dumps(held | facts))
        return tmp_path

    return write


def test_a_table_that_is_not_the_measured_one_is_not_sound(note):
    assert kept.check_bundled(note())["sound"].tolist() == [False]


@pytest.mark.parametrize("table", [None, b"junk", WHOLE[:30]], ids=["missing", "junk", "cut"])
def test_a_table_that_cannot_be_read_is_named(note, table):
    with pytest.raises(DatasetError, match=r"boxes\.csv\.gz"):
        kept.check_bundled(note(table))


@pytest.mark.parametrize(
    "tables", [{"boxes.csv.gz": {}}, ["boxes.csv.gz"], 3], ids=["no-facts", "list", "number"]
)
def test_a_note_without_its_facts_is_refused(note, tables):
    with pytest.raises(DatasetError, match="provenance"):
        kept.check_bundled(note(tables=tables))


def test_a_folder_without_notes_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="no provenance note"):
        kept.check_bundled(tmp_path)
    (tmp_path / "casia-a").mkdir()
    (tmp_path / "casia-a" / "provenance.json").write_text("{")
    with pytest.raises(DatasetError, match="not a provenance note"):
        kept.check_bundled(tmp_path)


def test_the_command_line_tells_a_damaged_table(note, monkeypatch, capsys):
    monkeypatch.setattr(kept.check_bundled, "__defaults__", (note(),))
    assert main(["data"]) == 1
    assert "False" in capsys.readouterr().out
