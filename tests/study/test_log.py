"""Who hears the log of a run."""

from __future__ import annotations

import logging

import pytest

from tacos_framework.errors import UserError
from tacos_framework.store import Results

log = logging.getLogger("toy_package.somewhere")


@pytest.fixture
def results(tmp_path):
    with Results.create(tmp_path / "run", {}) as results:
        yield results


def test_the_file_has_all_and_who_embeds_the_framework_still_sees_warnings(results, monkeypatch, capsys):
    monkeypatch.setattr(logging.root, "handlers", [])
    with results.logging({"toy_package"}):
        log.info("how far")
        log.warning("look here")
    log.info("after")
    assert capsys.readouterr().err == "look here\n"
    kept = (results.folder / "log.txt").read_text()
    assert [line.split(" ", 2)[2] for line in kept.splitlines()] == [
        "INFO toy_package.somewhere: how far",
        "WARNING toy_package.somewhere: look here",
    ]
    assert logging.getLogger("toy_package").level == logging.NOTSET


def test_a_log_that_cannot_be_opened_is_a_fault_of_the_folder(results):
    (results.folder / "log.txt").mkdir()
    with pytest.raises(UserError, match="the results cannot be written: Is a directory"):
        results.logging({"toy_package"})
