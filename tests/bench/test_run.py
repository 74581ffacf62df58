"""What a benchmark says when a peer fails."""

import sys

import numpy as np
import pytest

from bench.run import PEERS, _peers, _save
from mcnlab.errors import McnError


@pytest.fixture
def data(tmp_path):
    return _save(tmp_path, "data", served=np.ones((2, 2), bool))


def test_without_peers_there_is_none_to_ask(monkeypatch, data):
    monkeypatch.delenv(PEERS, raising=False)
    with _peers() as ask:
        assert ask("chama", data, n=1) is None


def test_a_peer_that_dies_is_reported_with_its_last_words(monkeypatch, data):
    monkeypatch.setenv(PEERS, sys.executable)
    with _peers() as ask:
        run = ask("no such task", data)
        for _ in range(2):  # the second finds it dead
            with pytest.raises(McnError, match=r"code 1 .*KeyError: 'no such task'.*peers\.txt"):
                run()


def test_a_peer_that_cannot_be_started_is_reported(monkeypatch, tmp_path):
    monkeypatch.setenv(PEERS, str(tmp_path / "python"))
    with pytest.raises(McnError, match=f"{PEERS} is .*No such file"), _peers():
        pass
