"""The windows of real people outdoors: bundled tables hold together and are what is measured."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.datasets import catalogue
from mcnlab.errors import ArgumentError
from mcnlab.lab.measure import measure_all
from mcnlab.tables import FRAME, SEQUENCE
from mcnlab.walking import outdoors


@pytest.fixture(scope="module")
def tables():
    """The bundled windows."""
    return {name: outdoors.apparent_speeds(name) for name in ("pets", "tud")}


def test_bundled_windows_hold_together(tables):
    for table in tables.values():
        assert not table.duplicated(["seconds", SEQUENCE, FRAME]).any()
        assert sorted(table["seconds"].unique()) == list(outdoors.SPEED_SECONDS)
        assert np.isfinite(table.select_dtypes(float)).all(axis=None)
        # Kept to four decimals: half a unit of the last on either side.
        for whole, part in (
            ("pixels", "sideways"),
            ("body_heights", "body_heights_sideways"),
            ("true_speed", "true_sideways"),
        ):
            assert (table[part] <= table[whole] + 1.01e-4).all()
        widths = table["pixels"] / table["share"]
        steady = table["pixels"] > 5
        # share is kept to 5e-7 of at least 0.006, pixels to 5e-5 of 5.
        np.testing.assert_allclose(widths[steady], widths[steady].median(), rtol=2e-4)


def test_the_windows_of_pets_are_those_of_its_headings(tables):
    headings = outdoors.pets2009_headings()
    table = tables["pets"][tables["pets"]["seconds"] == 1]
    both = table.merge(headings, on=[SEQUENCE, FRAME], suffixes=("", "_read"))
    assert len(both) == len(table)
    # Both are kept to four decimals, and lines through the same positions.
    np.testing.assert_allclose(both["true_speed"], both["true_speed_read"], atol=1.01e-4)
    np.testing.assert_allclose(both["body_heights"], both["speed"], atol=1.01e-4)


def test_a_name_that_is_not_held_is_refused():
    with pytest.raises(ArgumentError, match="name is 'mot20'"):
        outdoors.apparent_speeds("mot20")


@pytest.mark.parametrize("name", ["pets", "tud"])
def test_the_bundled_windows_are_what_is_measured_now(recordings, name, tables):
    files, measure = {
        "pets": (catalogue.pets_files, outdoors.measure_pets2009_speeds),
        "tud": (catalogue.tud_files, outdoors.measure_tud_speeds),
    }[name]
    if not all(path.is_file() for path in files(recordings)):
        pytest.skip(f"no {name} in MCNLAB_DATA")
    pd.testing.assert_frame_equal(
        measure(recordings), tables[name], check_dtype=False, rtol=0, atol=1e-9
    )


def test_measuring_writes_the_table_of_a_street(recordings, tmp_path):
    files = catalogue.tud_files(recordings)
    if not all(path.is_file() for path in files):
        pytest.skip("no TUD-Stadtmitte in MCNLAB_DATA")
    folder = tmp_path / "data" / "motchallenge" / "TUD-Stadtmitte"
    (folder / "gt").mkdir(parents=True)
    (folder / "gt" / "gt.txt").write_bytes(files[0].read_bytes())
    (folder / "seqinfo.ini").write_bytes(files[1].read_bytes())
    written = measure_all(tmp_path / "data", tmp_path / "out")
    assert [(path.parent.name, path.name) for path in written] == [
        (catalogue.TUD, "speeds.csv.gz"),
        (catalogue.TUD, "provenance.json"),
        (catalogue.MOTCHALLENGE, "pairs.csv.gz"),
        (catalogue.MOTCHALLENGE, "provenance.json"),
    ]
    for path in written[:2]:
        assert path.read_bytes() == (catalogue.BUNDLED / catalogue.TUD / path.name).read_bytes()
