"""Damaged and truncated files: a value or a fault, and nothing in silence."""

from __future__ import annotations

import random
import warnings

import pytest

from tacos_framework.errors import UserError
from tests.fuzz.mutations import damaged
from tests.fuzz.reader import read_or_refuse
from tests.fuzz.readers import READERS
from tests.fuzz.text_readers import TEXTS

INPUTS = 40
CUTS = 25


@pytest.mark.parametrize("name", READERS)
def test_examples_are_read(name, tmp_path):
    found = read_or_refuse(READERS[name], READERS[name].example(), tmp_path)
    assert not isinstance(found, UserError), found


@pytest.mark.parametrize("name", [name for name in READERS if name not in TEXTS])  # see test_damaged_texts
def test_damage_is_a_value_or_a_fault(name, tmp_path):
    reader = READERS[name]
    example = reader.example()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number in range(round(INPUTS * reader.share)):
            content = damaged(example, random.Random(f"{name} {number}"), structure=reader.structure)
            found = read_or_refuse(reader, content, tmp_path)  # any other exception fails the test
            assert found is not None


@pytest.mark.parametrize("name", [name for name, reader in READERS.items() if reader.whole_or_fault])
def test_what_lacks_its_end_is_a_fault(name, tmp_path):
    reader = READERS[name]
    example = reader.example()
    for length in sorted({len(example) * k // CUTS for k in range(CUTS)} | {len(example) - 1}):
        found = read_or_refuse(reader, example[:length], tmp_path)
        assert isinstance(found, UserError), f"{length} of {len(example)} bytes were read"
