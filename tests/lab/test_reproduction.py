"""A reproduction gathers rows and figures, whole or not at all."""

import nbformat
import pandas as pd
import pytest

from mcnlab.__main__ import main
from mcnlab.errors import ArgumentError
from mcnlab.lab import reproduction
from mcnlab.results import COLUMNS


def test_one_notebook_makes_numbers_figures_and_a_page(tmp_path):
    page = reproduction.reproduce(tmp_path, only="mirror", n_jobs=1)
    table = pd.read_csv(tmp_path / "results.csv", dtype=str, na_filter=False)
    assert tuple(table.columns) == COLUMNS
    assert table.set_index("id").loc["casia-a.videos", ["thesis", "here"]].tolist() == [
        "320",
        "224",
    ]
    assert (tmp_path / "figures" / "figure-mirror.png").is_file()
    assert (tmp_path / "notebooks" / "mirror_casia_a.ipynb").is_file()
    text = page.read_text()
    assert "figures/figure-mirror.png" in text
    assert "casia-a.videos_per_direction" in text
    assert not (tmp_path / "rows").exists()
    first = (tmp_path / "results.csv").read_bytes()
    assert main(["reproduce", "--out", str(tmp_path), "--only", "mirror"]) == 0
    assert (tmp_path / "results.csv").read_bytes() == first


def test_the_notebooks_themselves_are_not_written_over():
    with pytest.raises(ArgumentError, match="another folder"):
        reproduction.reproduce(reproduction.FOLDER.parent)


def test_workers_that_began_with_other_data_do_not_keep_them(tmp_path, monkeypatch, casia_folder):
    """joblib's workers live on, with the environment of their start."""
    from joblib import Parallel, delayed

    data = tmp_path / "data"
    data.mkdir()
    (data / "casia-a").symlink_to(casia_folder)
    monkeypatch.setenv("MCNLAB_DATA", str(data))
    Parallel(n_jobs=2)(delayed(str)(number) for number in range(4))
    monkeypatch.delenv("MCNLAB_DATA")
    reproduction.reproduce(tmp_path / "out", only="mirror", n_jobs=2)
    assert "casia-a.videos,320,224" in (tmp_path / "out" / "results.csv").read_text()


def test_an_unknown_notebook_is_named():
    with pytest.raises(ArgumentError, match="nonsense"):
        reproduction.choose_notebooks("nonsense")


def test_a_failing_notebook_is_named_with_its_error(tmp_path):
    cell = nbformat.v4.new_code_cell("raise RuntimeError('the cat sat on it')")
    path = tmp_path / "broken.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=[cell]), path)
    with pytest.raises(reproduction.NotebookError, match=r"broken.*the cat sat on it"):
        reproduction.run_notebook(path)
