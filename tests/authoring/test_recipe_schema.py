"""The schema that editors check recipes with: right recipes pass, typical mistakes do not."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from tacos_framework.cli import tacos_main
from tacos_framework.components import Component
from tacos_framework.hookspecs import hookimpl
from tacos_framework.packaged_resources import shipped_folder, shipped_recipes
from tacos_framework.plugins import Plugins
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_plugins.authoring.reference.recipe_schema import recipe_schema
from tests.docs.pages import Block, blocks

SHIPPED = sorted(shipped_recipes().values())
IN_DOCS = [  # but for the tutorial's, whose component is not installed here
    block
    for block in blocks(language="yaml")
    if block.text.startswith("tacos:") and block.title != "things.yaml"
]


class Offer:
    """Components that are not what they should be, and a procedure."""

    @hookimpl
    def tacos_components(self) -> list[Component]:
        return [
            Component("task", "needy", "x:Y", summary="Needs a package.", requires=("not_there=a-package",)),
            Component("effect", "broken", "not_there_at_all:Effect", summary="Cannot be imported."),
            Component("task", "broken", "not_there_at_all:Task", summary="Cannot be imported."),
            Component("procedure", "count", "toy_procedure:Counting", summary="Counts."),
        ]


@pytest.fixture(scope="module")
def validator() -> Draft202012Validator:
    schema = recipe_schema(Plugins.discover()).schema
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(json.loads(json.dumps(schema)))


def complaints(validator: Draft202012Validator, recipe: Any) -> str:
    """What the schema finds, one line each with its place."""
    return "\n".join(
        f"{error.json_path}: {error.message}" for error in _leaves(validator.iter_errors(recipe))
    )


def _leaves(errors: Any) -> Any:
    for error in errors:
        if error.context:
            yield from _leaves(error.context)
        else:
            yield error


@pytest.fixture
def quick() -> dict[str, Any]:
    data = read_yaml(shipped_folder("recipes") / "headset_quick.yaml").data
    assert isinstance(data, dict)
    return copy.deepcopy(data)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_recipes_are_right(validator: Draft202012Validator, path: Path) -> None:
    assert complaints(validator, read_yaml(path).data) == ""


@pytest.mark.parametrize("block", IN_DOCS, ids=str)
def test_whole_recipes_of_the_docs_are_right(validator: Draft202012Validator, block: Block) -> None:
    assert complaints(validator, read_yaml(block.text, name=str(block)).data) == ""


def at(*path: str | int, value: Any) -> Callable[[Any], None]:
    """A change of a recipe: a value put at a path."""

    def change(recipe: Any) -> None:
        for step in path[:-1]:
            recipe = recipe[step]
        recipe[path[-1]] = value

    return change


def without(*path: str) -> Callable[[Any], None]:
    """A change of a recipe: a key taken away."""

    def change(recipe: Any) -> None:
        for step in path[:-1]:
            recipe = recipe[step]
        del recipe[path[-1]]

    return change


MISTAKES = [
    (at("optimiser", value={}), "'optimiser' was unexpected"),
    (without("fitness"), "'fitness' is a required property"),
    (without("tacos"), "'tacos' is a required property"),
    (at("tacos", value=2), "$.tacos: 1 was expected"),
    (at("seed", value="seven"), "$.seed: 'seven' is not of type 'integer'"),
    (at("optimizer", "use", value="optimizer.genetics"), "'optimizer.genetics' is not one of"),
    (at("optimizer", "use", value="task.orb-features"), "'task.orb-features' is not one of"),
    (at("optimizer", "populations", value=3), "'populations' was unexpected"),
    (at("optimizer", "evaluations", value=0), "$.optimizer.evaluations: 0 is less than the minimum"),
    (at("nodes", "frames", "calibratoin", value="x"), "'calibratoin' was unexpected"),
    (at("nodes", "frames", "use", value="rig.monocular"), "'rig.monocular' is not one of"),
    (at("nodes", "isp", value={"use": "effect.jpeg"}), "$.nodes.isp: 'in' is a required property"),
    (at("nodes", "isp", value={"use": "effect.jpeg", "in": {"capture": "x"}}), "'capture' was unexpected"),
    (at("effects", value=[{"use": "effect.jpeg", "in": {"frames": "x"}}]), "'in' was unexpected"),
    (at("effects", value=[{"use": "effect.jpeg", "cameras": []}]), "[] should be non-empty"),
    (at("effects", value=[{"use": "effect.jpeg", "name": "A b"}]), "'A b' does not match"),
    (at("scenario", value=[{"gain_db": 5}]), "'name' is a required property"),
    (at("scenario", value=[{"name": "day", "weight": 0}]), "0 is less than or equal to the minimum"),
    (at("study", value={"scenarios": "best"}), "'best' is not one of"),
    (without("nodes", "frames", "in"), "$.nodes.frames: 'in' is a required property"),
    (at("nodes", "frames", "in", value={"captures": "capture"}), "'captures' was unexpected"),
    (at("nodes", "features", "train", value={"weights": "shared"}), "'train' was unexpected"),
    (at("nodes", "Frames", value={"use": "scene.indoor"}), "'Frames' does not match"),
    (at("rig", "binnning", value=2), "'binnning' was unexpected"),
    (at("design", "pitch", value={"between": [0, 1]}), "'pitch' is not one of"),
    (at("design", "pitch_deg", value={"betwen": [0, 1]}), "'betwen' was unexpected"),
    (at("design", "pitch_deg", value={"between": [0]}), "[0] is too short"),
    (at("constraints", "fov_deg", value={"max": 90}), "'fov_deg' is not one of"),
    (at("effects", value=[{"use": "effect.vignetting", "k9": 1}]), "'k9' was unexpected"),
    (at("executor", value={"use": "executor.process", "workers": 0}), "0 is less than the minimum"),
    (at("scenario", "illumination_lux", value=0), "0 is less than or equal to the minimum"),
    (at("use", value="procedure.no-such"), "'procedure.no-such' is not one of"),
]


@pytest.mark.parametrize(("change", "said"), MISTAKES, ids=[said for _, said in MISTAKES])
def test_a_mistake_is_found(
    validator: Draft202012Validator, quick: dict[str, Any], change: Callable[[Any], None], said: str
) -> None:
    change(quick)
    assert said in complaints(validator, quick)


def test_settings_of_nodes_may_be_designed(validator: Draft202012Validator, quick: dict[str, Any]) -> None:
    quick["design"]["features.fast_threshold"] = {"choose": [5, 7]}
    quick["design"]["scenario.gain_db"] = {"between": [0, 10]}
    quick["design"]["effects.lens-blur_2.left.sigma_px"] = {"between": [0, 10]}
    assert complaints(validator, quick) == ""


def test_effects_are_listed_or_nodes_and_scenarios_may_be_several(
    validator: Draft202012Validator, quick: dict[str, Any]
) -> None:
    quick["effects"] = [{"use": "effect.jpeg", "name": "worse", "cameras": ["camera"], "quality": 10}]
    quick["nodes"]["isp"] = {
        "use": "effect.jpeg",
        "in": {"frames": "frames"},
        "cameras": ["camera"],
        "quality": 60,
    }
    quick["scenario"] = [{"name": "day"}, {"name": "night", "weight": 2, "illumination_lux": 1}]
    quick["study"] = {"scenarios": "worst"}
    assert complaints(validator, quick) == ""


def test_variables_may_be_fixed(validator: Draft202012Validator, quick: dict[str, Any]) -> None:
    del quick["design"]["pitch_deg"]
    quick["rig"]["pitch_deg"] = 10
    assert complaints(validator, quick) == ""
    quick["rig"]["pitch_deg"] = 100
    assert "100 is greater than the maximum" in complaints(validator, quick)


def test_components_that_cannot_be_loaded_are_named_and_allowed(quick: dict[str, Any]) -> None:
    plugins = Plugins.discover()
    plugins.register(Offer())
    described = recipe_schema(plugins)
    absent = {r.component.use for r in plugins if r.component.missing_packages()} - {"task.needy"}
    assert {use: why for use, why in described.undescribed.items() if use not in absent} == {
        "task.needy": "task.needy needs packages that are not installed: a-package",
        "effect.broken": "its import failed: ModuleNotFoundError: No module named 'not_there_at_all'",
        "task.broken": "its import failed: ModuleNotFoundError: No module named 'not_there_at_all'",
    }
    quick["nodes"]["needy"] = {"use": "task.needy", "in": {"frames": "frames"}, "anything": 1}
    quick["nodes"]["broken"] = {"use": "effect.broken", "in": {"frames": "frames"}}
    quick["effects"] = [{"use": "effect.broken", "anything": 1}]
    assert complaints(Draft202012Validator(described.schema), quick) == ""


def test_a_procedures_settings_stand_at_the_top() -> None:
    plugins = Plugins.discover()
    plugins.register(Offer())
    validator = Draft202012Validator(recipe_schema(plugins).schema)
    recipe = {"tacos": 1, "name": "squares", "use": "procedure.count", "limit": 3, "seed": 4}
    assert complaints(validator, recipe) == ""
    assert "'limits' was unexpected" in complaints(validator, {**recipe, "limits": 3})
    assert "'limit' is a required property" in complaints(
        validator, {key: value for key, value in recipe.items() if key != "limit"}
    )
    assert "'rig' was unexpected" in complaints(validator, {**recipe, "rig": {"use": "rig.monocular"}})


def test_the_command_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert tacos_main(["schema"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out) == recipe_schema(Plugins.discover()).schema
    assert "failed" not in printed.err
