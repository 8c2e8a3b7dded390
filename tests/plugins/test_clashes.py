"""Of two plugins that offer one name neither wins, and whoever needs the name is told of both."""

from __future__ import annotations

import pytest

from tacos_framework.cli import run_main, tacos_main
from tacos_framework.components import Component
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins

OFFER = """
    from tacos_framework import Component, hookimpl

    @hookimpl
    def tacos_components():
        return [Component("sensor", "affine-noise", "MODULE:Sensor", summary="Another.")]
"""

RECIPE = """\
tacos: 1
name: small
rig: {use: rig.monocular}
design: {focal_length_mm: {between: [2, 8]}}
nodes:
  world: {use: scene.indoor}
  capture: {use: renderer.analytic, in: {episode: world}}
  frames: {use: sensor.affine-noise, in: {capture: capture}}
  judge: {use: task.orb-features, in: {frames: frames}}
fitness: [{score: judge.inliers, weight: 1}]
optimizer: {use: optimizer.random}
"""

BOTH = "sensor.affine-noise is offered by acme-cameras and by tacos-framework"


def offering(*uses: str) -> object:
    """A plugin that offers components."""

    class Offer:
        @hookimpl
        def tacos_components(self):
            return [Component(*use.split("."), "x:Y", summary="A thing.") for use in uses]

    return Offer()


@pytest.fixture
def clash(distribution):
    distribution("acme-cameras", OFFER.replace("MODULE", "acme_cameras"))


def test_a_recipe_that_needs_the_name_is_told_of_both(clash, tmp_path, capsys):
    (tmp_path / "small.yaml").write_text(RECIPE)
    assert run_main([str(tmp_path / "small.yaml"), "--check"]) == 2
    said = capsys.readouterr().err
    assert f"small.yaml:8:12: {BOTH}" in said
    assert "to do: Uninstall acme-cameras or tacos-framework." in said


def test_plugins_and_doctor_list_it(clash, capsys):
    assert tacos_main(["plugins"]) == 0
    printed = capsys.readouterr()
    assert f"{BOTH}, so the name can mean neither" in printed.err
    assert "sensor.affine-noise" not in printed.out
    assert tacos_main(["doctor"]) == 1
    assert f"BAD  plugin acme-cameras and tacos-framework: {BOTH}" in capsys.readouterr().out


def test_the_other_names_of_both_stay(clash):
    plugins = Plugins.discover()
    assert plugins.resolve("sensor.emva")
    assert "sensor.affine-noise" not in {registered.component.use for registered in plugins}


@pytest.mark.parametrize("order", [("first", "second"), ("second", "first")])
def test_what_is_registered_by_hand_clashes_alike(order):
    plugins = Plugins()
    for name in order:
        plugins.register(offering("task.same", f"task.{name}"), name)
    with pytest.raises(UserError) as caught:
        plugins.component("task.same")
    (fault,) = caught.value.faults
    assert fault.what == f"task.same is offered by {order[0]} and by {order[1]}"
    assert fault.remedy.startswith(f"Use one of {order[0]} and {order[1]} alone")
    assert plugins.component("task.first")
    assert [failure.uses for failure in plugins.failures] == [("task.same",)]


def test_a_plugin_that_lists_a_name_twice_is_told_to_list_it_once():
    plugins = Plugins()
    plugins.register(offering("task.same", "task.same"), "acme")
    with pytest.raises(UserError, match="Have acme list it once"):
        plugins.component("task.same")


def command(name: str) -> str:
    """A plugin that offers a command."""
    return f"""
    from tacos_framework.components import Command
    from tacos_framework import hookimpl

    @hookimpl
    def tacos_commands():
        return [Command({name!r}, "Say something.", lambda parser: None, lambda arguments: 0)]
    """


def test_commands_of_one_name_are_both_left_out(distribution, capsys):
    distribution("acme-first", command("shine"))
    distribution("acme-second", command("shine"))
    plugins = Plugins.discover()
    assert "shine" not in {each.name for each in plugins.offers.commands()}
    (failure,) = plugins.failures
    assert "the command 'shine' is offered by acme-first and by acme-second" in failure.reason
    assert tacos_main(["shine"]) == 2
    assert tacos_main(["plugins"]) == 0
    assert "the command 'shine' is offered by" in capsys.readouterr().err


def test_no_plugin_takes_over_a_command_of_tacos(distribution, capsys):
    distribution("acme-cameras", command("doctor"))
    assert tacos_main(["plugins"]) == 0
    said = capsys.readouterr().err
    assert "the command 'doctor' is offered by tacos itself and by acme-cameras, so it is left out" in said
