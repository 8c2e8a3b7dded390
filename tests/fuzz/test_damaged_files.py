"""Damaged and truncated files: a value or a fault, and nothing in silence."""

from __future__ import annotations

import random
import warnings

import pytest

from tacos_framework.errors import UserError
from tests.fuzz.binary_readers import BINARY_READERS, read_or_refuse
from tests.fuzz.mutations import damaged

INPUTS = 40
CUTS = 25


@pytest.mark.parametrize("name", BINARY_READERS)
def test_examples_are_read(name, tmp_path):
    found = read_or_refuse(BINARY_READERS[name], BINARY_READERS[name].example(), tmp_path)
    assert not isinstance(found, UserError), found


@pytest.mark.parametrize("name", BINARY_READERS)
def test_damage_is_a_value_or_a_fault(name, tmp_path):
    reader = BINARY_READERS[name]
    example = reader.example()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number in range(INPUTS):
            content = damaged(example, random.Random(f"{name} {number}"), structure=reader.structure)
            found = read_or_refuse(reader, content, tmp_path)  # any other exception fails the test
            assert found is not None


@pytest.mark.parametrize("name", [name for name, reader in BINARY_READERS.items() if reader.whole_or_fault])
def test_what_lacks_its_end_is_a_fault(name, tmp_path):
    reader = BINARY_READERS[name]
    example = reader.example()
    for length in sorted({len(example) * k // CUTS for k in range(CUTS)} | {len(example) - 1}):
        found = read_or_refuse(reader, example[:length], tmp_path)
        assert isinstance(found, UserError), f"{length} of {len(example)} bytes were read"
