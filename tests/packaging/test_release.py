"""A release: one version in both distributions, the citation and the changelog."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

import tacos_framework
import tacos_validation

ROOT = Path(__file__).parents[2]


def test_both_distributions_and_the_citation_have_one_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert tacos_validation.__version__ == tacos_framework.__version__ == citation["version"]


def test_the_changelog_has_notes_of_this_version_and_the_day_of_the_citation():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    text = (ROOT / "CHANGELOG.md").read_text()
    version, day = re.findall(r"^## \[(\d.*?)\] - (\S+)$", text, re.MULTILINE)[0]
    notes = text.split(f"## [{version}]")[1]
    assert (version, day) == (tacos_framework.__version__, str(citation["date-released"]))
    assert "- " in notes
