"""Notes quote the recipe as it is run."""

from __future__ import annotations

import pytest

from tacos_framework.errors import UserError
from tacos_framework.recipe.loading import load_recipe
from tests.toy_study import toy_recipe


def test_a_note_follows_set() -> None:
    for frames in (5, 7):
        recipe = load_recipe("headset_quick", {"nodes.world.frames": frames})
        assert f"{frames} frames of each small house" in recipe.quoted_notes[0]


def test_a_note_that_quotes_what_is_not_there_is_a_fault() -> None:
    with pytest.raises(UserError, match=r"quotes \{rig\.bining\}"):
        load_recipe("headset_quick", {"notes": ["{rig.bining}"]})


def test_braces_of_other_kinds_stay() -> None:
    assert toy_recipe(notes=["{a, b} and {}"]).quoted_notes == ("{a, b} and {}",)
