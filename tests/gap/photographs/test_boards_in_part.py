"""What is guessed to be print, among views of a board."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from tacos_gap.photographs.given import Given
from tacos_gap.photographs.importing import _likelier_boards


def picture(kind: str, doubt: str = "") -> Any:
    return SimpleNamespace(name=f"{kind}.png", shown=SimpleNamespace(kind=kind, doubt=doubt))


@pytest.mark.parametrize(
    ("boards", "doubt", "count"), [(9, "taken for sharp edges of a print.", 1), (9, "", 0), (1, "perhaps", 0)]
)
def test_a_guessed_edge_among_many_boards_is_a_board_not_seen_whole(boards, doubt, count):
    views, other = [picture("board") for _ in range(boards)], picture("edge", doubt)
    assert _likelier_boards([*views, other], views, Given()) == [other][:count]
    assert not _likelier_boards([*views, other], views, Given(kinds={other.name: "edge"}))
