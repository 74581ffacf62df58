"""The page says what the rows say, figure by figure, and escapes it."""

import pandas as pd
import pytest

from mcnlab.figures.registry import FIGURES
from mcnlab.lab import report
from mcnlab.results import COLUMNS, SECONDS


@pytest.fixture
def entry():
    """A thesis figure that shows a number."""
    return next(one for one in FIGURES.values() if one.section and one.ids)


def page_of(rows, out, *, pictures=()):
    """The page of some rows, given as dicts, and figures."""
    (out / "figures").mkdir(exist_ok=True)
    for one in pictures:
        (out / "figures" / one.file).touch()
    return report.render(pd.DataFrame([dict.fromkeys(COLUMNS, "") | row for row in rows]), out)


def test_the_page_escapes_what_it_is_given(tmp_path):
    page = page_of([{"id": "<script>", "here": "1"}], tmp_path)
    assert "<script>" not in page.split("</style>")[1]
    assert "&lt;script&gt;" in page


def test_a_figure_stands_with_its_claim_and_its_numbers(tmp_path, entry):
    row = {"id": entry.ids[0], "thesis": "0.9", "here": "0.97", "low": "0.95", "high": "0.99"}
    page = page_of([row], tmp_path, pictures=[entry])
    assert page.count("<article") == 1
    assert f'<article id="{entry.number}">' in page
    assert f'src="figures/{entry.file}"' in page
    assert f"section {entry.section}" in page
    article = page.split("<article")[1]
    assert "0.97 [0.95, 0.99]" in article
    assert "exceeded: thesis 0.9" in article


def test_a_figure_that_was_not_drawn_is_left_out(tmp_path, entry):
    assert entry.file not in page_of([{"id": entry.ids[0], "here": "1"}], tmp_path)


def test_seconds_stand_apart_and_only_claims_come_first(tmp_path):
    rows = [{"id": "some.count", "here": "3"}, {"id": "some.time", "here": "2", "unit": SECONDS}]
    page = page_of(rows, tmp_path)
    first, rest = page.split("<details>")
    assert "some." not in first
    numbers, timings = rest.split("<h2>Timings</h2>")
    assert "some.count" in numbers
    assert "some.time" not in numbers
    assert "some.time" in timings
    assert "Timings" not in page_of(rows[:1], tmp_path)
