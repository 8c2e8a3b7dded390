"""Whatever stands in a file, its reader gives a value or says what is wrong, soon, by no other exception."""

from __future__ import annotations

import json
from copy import deepcopy
from datetime import timedelta
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tacos_framework.settings.yaml_reader import read_yaml
from tests.fuzz.reader import read_or_refuse
from tests.fuzz.text_readers import TEXTS

BOUNDED = settings(
    max_examples=30,  # `tests.fuzz.campaign` tries thousands
    deadline=timedelta(seconds=10),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    derandomize=True,
)
WORDS = st.sampled_from(
    [
        "use",
        "",
        "between",
        "from",
        "in",
        "..",
        "/",
        "a/b",
        "\x00",
        "é",
        "rig.monocular",
        "width_mm",
        "0",
        "-",
        "nan",
    ]
)
SCALARS = (
    st.none() | st.booleans() | st.integers() | st.floats() | WORDS | st.text(max_size=8) | st.just(10**400)
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(WORDS | st.text(max_size=4), inner, max_size=3)
    ),
    max_leaves=6,
)
YAML = [name for name, reader in TEXTS.items() if reader.suffix == ".yaml"]


def containers(value: Any) -> list[Any]:
    """Every mapping and list in a document that is not empty."""
    inner = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    found = [value] if inner else []
    return found + [container for item in inner for container in containers(item)]


@st.composite
def mutations(draw: st.DrawFn, name: str) -> Any:
    """An example's document with some entries replaced, removed or added."""
    document = deepcopy(read_yaml(TEXTS[name].example().decode()).data)
    for _ in range(draw(st.integers(1, 3))):
        if not (places := containers(document)):
            break
        place = draw(st.sampled_from(places))
        key = draw(st.sampled_from(list(place) if isinstance(place, dict) else range(len(place))))
        how = draw(st.sampled_from(["replace", "remove", "add"]))
        if how == "replace":
            place[key] = draw(VALUES)
        elif how == "remove":
            del place[key]
        elif isinstance(place, dict):
            place[draw(WORDS | st.text(max_size=6))] = draw(VALUES)
        else:
            place.insert(key, draw(VALUES))
    return document


@pytest.mark.parametrize("name", YAML)
@BOUNDED
@given(data=st.data())
def test_documents_that_are_nearly_right(name, tmp_path, data):
    document = data.draw(mutations(name))
    read_or_refuse(TEXTS[name], json.dumps(document, ensure_ascii=False).encode("utf-8", "replace"), tmp_path)


@pytest.mark.parametrize("name", TEXTS)
@BOUNDED
@given(
    content=st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace"))
)
def test_any_bytes(name, tmp_path, content):
    read_or_refuse(TEXTS[name], content, tmp_path)


@pytest.mark.parametrize("name", TEXTS)
@BOUNDED
@given(data=st.data())
def test_files_with_a_piece_cut_out_or_put_in(name, tmp_path, data):
    example = TEXTS[name].example()
    start = data.draw(st.integers(0, len(example)))
    stop = data.draw(st.integers(start, min(start + 40, len(example))))
    piece = data.draw(
        st.binary(max_size=10) | st.sampled_from([b"\n", b":", b"[", b"{", b'"', b"\t", b",", b"&a *a"])
    )
    read_or_refuse(TEXTS[name], example[:start] + piece + example[stop:], tmp_path)
