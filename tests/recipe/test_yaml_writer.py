"""What is written is read back unchanged."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.settings.yaml_reader import read_yaml
from tacos_framework.settings.yaml_writer import to_yaml

printable = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp")))
scalars = st.none() | st.booleans() | st.integers(-(10**9), 10**9) | st.floats(-1e9, 1e9) | printable
values = st.recursive(
    scalars, lambda inner: st.lists(inner) | st.dictionaries(printable, inner), max_leaves=12
)


@given(st.dictionaries(printable, values), st.sampled_from([None, False]))
def test_it_comes_back(data, flow_style):
    assert read_yaml(to_yaml(data, flow_style=flow_style), "it").data == data


@pytest.mark.parametrize("text", ["INF", "1e3", "0x10", "no", "~", "null", "2026-11-21", "1_000", "#", ""])
def test_text_that_looks_like_something_else_stays_text(text):
    assert read_yaml(to_yaml([text]), "it").data == [text]
