"""``tacos recipes``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.cli.tacos import main
from tacos_framework.packaged_resources import recipe_folders, shipped_recipes
from tacos_plugins.authoring.recipes import summary_of


def test_every_recipe_has_a_line_of_its_own_that_says_what_it_is_for(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["recipes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    names = shipped_recipes()
    assert [line.split()[0] for line in lines[: len(names)]] == list(names)
    assert all(len(line.split()) > 4 for line in lines[: len(names)])
    assert all(str(folder) in lines[-1] for folder in recipe_folders())


@pytest.mark.parametrize(
    ("text", "summary"),
    [
        ("# Small (paper, Sec. 4.3). For a GPU.\ntacos: 1\n", "Small (paper, Sec. 4.3)"),
        ("# Does it pay?\n# The one beside the other.\nname: n\n", "Does it pay?"),
        (
            "# One that goes on\n# below: as this.\n#   tacos-run it\nname: n\n",
            "One that goes on below: as this",
        ),
        ("tacos: 1\nname: nameless\n", "nameless"),
    ],
)
def test_a_recipe_is_summed_up_by_its_first_sentence(text: str, summary: str, tmp_path: Path) -> None:
    recipe = tmp_path / "it.yaml"
    recipe.write_text(text)
    assert summary_of(recipe) == summary
