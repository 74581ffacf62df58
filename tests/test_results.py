"""The table of results, and files that are written whole."""

import hashlib

import numpy as np
import pandas as pd
import pytest

from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.files import sha256_of, write_whole
from mcnlab.results import COLUMNS, Results, verdict_of
from mcnlab.statistics import (
    Estimate,
)


@pytest.fixture
def results():
    results = Results("02_direction", data="casia-a")
    results.add("direction.share", Estimate(0.93751, 0.9, 0.96, 168), thesis=0.9375)
    results.add("videos", 224, thesis=320)
    results.add("speed", 1234.56, unit="px", data="pets2009")
    results.add("direction.seconds", 0.5, thesis=1.04, unit="s")
    return results


def test_rows_are_text_with_four_decimals(results):
    table = results.table()
    assert list(table.columns) == list(COLUMNS)
    expected = ["direction.share", "0.9375", "0.9375", "0.9", "0.96", "", "casia-a", "168"]
    assert table.iloc[0].tolist() == [*expected, "02_direction"]
    assert table.loc[1, ["thesis", "here", "low", "high", "n"]].tolist() == [
        "320",
        "224",
        "",
        "",
        "",
    ]
    assert table.loc[2, ["here", "unit", "data"]].tolist() == ["1235", "px", "pets2009"]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.0, "1"),
        (100.0, "100"),
        (-0.25, "-0.25"),
        (-1e-5, "0"),
        (1 / 3, "0.3333"),
        (999.99999, "1000"),
        (12345.6, "12346"),
        (np.int64(7), "7"),
    ],
)
def test_numbers_are_written_plainly(value, text):
    results = Results("notebook")
    results.add("number", value)
    assert results.rows[0].here == text


@pytest.mark.parametrize("here", [np.nan, np.inf, Estimate(np.nan, 0, 1, 3), "half"])
def test_a_number_that_is_none_is_refused(results, here):
    with pytest.raises(ArgumentError, match="odd"):
        results.add("odd", here)


@pytest.mark.parametrize(
    "more", [{"thesis": np.nan}, {"here": Estimate(0.5, np.nan, 1.0, 3)}], ids=["thesis", "low"]
)
def test_a_row_never_says_nan(results, more):
    with pytest.raises(ArgumentError):
        results.add("odd", **{"here": 0.5, **more})


def test_an_id_is_reported_once(results):
    with pytest.raises(ArgumentError, match="'videos' was reported before"):
        results.add("videos", 3)


def test_showing_prints_all_but_timings_and_writes_nothing(results, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    results.show()
    lines = capsys.readouterr().out.splitlines()
    assert [word.strip() for word in lines[0].split("|")][:3] == ["quantity", "thesis", "here"]
    cells = [[cell.strip() for cell in line.split("|")] for line in lines[2:]]
    assert cells == [
        ["direction.share", "0.9375", "0.9375", "0.9 to 0.96", "168"],
        ["videos", "320", "224", "", ""],
        ["speed", "", "1235 px", "", ""],
    ]
    assert list(tmp_path.iterdir()) == []


def test_showing_writes_every_row_when_reproducing(results, tmp_path, monkeypatch):
    monkeypatch.setenv("MCNLAB_OUT", str(tmp_path / "build"))
    results.show()
    path = tmp_path / "build" / "rows" / "02_direction.csv"
    written = pd.read_csv(path, dtype=str, keep_default_na=False)
    assert written.equals(results.table())
    assert "direction.seconds" in written["id"].tolist()
    first = path.read_bytes()
    results.show()
    assert path.read_bytes() == first


def test_an_empty_report_is_shown(capsys):
    Results("notebook").show()
    assert len(capsys.readouterr().out.splitlines()) == 2


@pytest.mark.parametrize("data", ["grüße\n", b"\x00\xff"])
def test_a_file_is_written_whole(tmp_path, data):
    path = tmp_path / "new" / "folder" / "file"
    assert write_whole(path, data) == path
    assert path.read_bytes() == (data if isinstance(data, bytes) else data.encode())
    assert write_whole(path, b"second").read_bytes() == b"second"
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("fault", [OSError("disk full"), KeyboardInterrupt()])
@pytest.mark.parametrize("step", ["chmod", "replace"])
def test_an_interrupted_write_leaves_the_old_file(tmp_path, monkeypatch, fault, step):
    path = write_whole(tmp_path / "file", "old")

    def fail(*_):
        raise fault

    with monkeypatch.context() as patch:
        patch.setattr(f"pathlib.Path.{step}", fail)
        with pytest.raises(type(fault)):
            write_whole(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_what_cannot_be_written_leaves_the_old_file(tmp_path):
    path = write_whole(tmp_path / "file", "old")
    with pytest.raises(TypeError):
        write_whole(path, 3)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_checksum_covers_names_order_and_content(tmp_path):
    one, two = (write_whole(tmp_path / "in" / name, name * 2) for name in "ab")
    assert sha256_of([one, two]) == hashlib.sha256(b"a\0aab\0bb").hexdigest()
    assert sha256_of([one], root=tmp_path) == hashlib.sha256(b"in/a\0aa").hexdigest()
    assert sha256_of([two, one]) != sha256_of([one, two])
    with pytest.raises(DatasetError, match="cannot be read"):
        sha256_of([tmp_path / "gone"])


@pytest.mark.parametrize(
    ("thesis", "here", "low", "high", "unit", "verdict"),
    [
        ("", "0.5", "", "", "", "no claim"),
        ("40", "40", "", "", "videos", "holds"),
        ("40", "28", "", "", "videos", "other data"),
        ("0.9", "0.88", "0.85", "0.91", "", "holds"),
        ("0.9", "0.8", "0.75", "0.85", "", "below the claim"),
        ("0.9", "0.97", "0.95", "0.99", "", "exceeded"),
        ("0.9", "0.8", "", "", "", "below the claim"),
        ("1.04", "0.05", "", "", "s", "faster"),
        ("1.04", "1.05", "", "", "s", "slower"),
    ],
)
def test_verdicts(thesis, here, low, high, unit, verdict):
    row = {"thesis": thesis, "here": here, "low": low, "high": high, "unit": unit}
    assert verdict_of(row) == verdict
