"""The diagnosis of the gap between simulation and real camera, listed by string, so that it stays light."""

from __future__ import annotations

from tacos_framework import Command, Component, ReferencePage, hookimpl
from tacos_gap import commands


@hookimpl
def tacos_components() -> list[Component]:
    return [
        Component(
            "procedure",
            "simulate-captures",
            "tacos_gap.procedures.simulate_captures:SimulateCaptures",
            summary="A folder of captures from our own simulator, to rehearse a diagnosis without a camera.",
        ),
        Component(
            "procedure",
            "diagnose",
            "tacos_gap.procedures.diagnose:Diagnose",
            summary="Where a simulation and real captures part, and which effect causes it.",
        ),
    ]


@hookimpl
def tacos_commands() -> list[Command]:
    return [
        Command(
            "captures",
            "captures of a real camera: what to photograph, import photographs, simulate or check a folder",
            commands.add_arguments,
            commands.captures,
        )
    ]


@hookimpl
def tacos_reference_pages() -> list[ReferencePage]:
    from tacos_gap.captures.reference import captures_page

    return [ReferencePage("captures.md", captures_page)]
