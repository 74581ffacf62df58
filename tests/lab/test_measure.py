"""Measuring writes what is bundled."""

import pytest

from mcnlab.__main__ import main
from mcnlab.datasets import kept
from mcnlab.errors import DatasetError
from mcnlab.lab import measure
from mcnlab.vision import recordings


def test_measuring_writes_tables_that_pass_the_check(casia_folder, tmp_path):
    casia_folder.rename(tmp_path.parent / f"{tmp_path.name}-data")
    data, out = tmp_path.parent / f"{tmp_path.name}-data", tmp_path / "out"
    (data / "casia-a").mkdir()
    (data / "silhouettes").rename(data / "casia-a" / "silhouettes")
    (data / "directions.csv").rename(data / "casia-a" / "directions.csv")
    written = measure.measure_all(data, out)
    assert all(path.is_file() for path in written)
    assert kept.check_bundled(out)["sound"].tolist() == [True]
    again = recordings.read_casia_a(out / "casia-a")
    assert again.boxes.equals(recordings.measure_casia_a(data / "casia-a", n_jobs=1).boxes)
    first = [path.read_bytes() for path in written]
    assert [path.read_bytes() for path in measure.measure_all(data, out)] == first


def test_a_folder_without_recordings_cannot_be_measured(tmp_path):
    with pytest.raises(DatasetError, match="holds neither"):
        measure.measure_all(tmp_path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_command_line_measures_only_what_it_is_given(tmp_path, capsys):
    assert main(["measure", "--out", str(tmp_path / "out")]) == 2
    assert "no folder of recordings" in capsys.readouterr().err
    assert main(["measure", "--data", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "holds neither" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
