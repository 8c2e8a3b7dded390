"""The worlds that ship with tacos-framework, listed by string: importing it is light."""

from __future__ import annotations

from tacos_framework import Command, Component, hookimpl
from tacos_worlds.recorded.imports import commands


@hookimpl
def tacos_components() -> list[Component]:
    return [
        Component(
            "scene",
            "indoor",
            "tacos_worlds.indoor.scene:IndoorScene",
            summary="Procedural furnished rooms with thresholds at the doors and an agent walking through.",
        ),
        Component(
            "scene",
            "street",
            "tacos_worlds.street.scene:StreetScene",
            summary="A procedural town by day or by night, and a car driving through its streets.",
        ),
        Component(
            "scene",
            "imported",
            "tacos_worlds.imported.scene:ImportedScene",
            summary="A room, building or street of your own: glTF, OBJ or PLY, lit, labelled and walked in.",
        ),
        Component(
            "scene",
            "recorded",
            "tacos_worlds.recorded.scene:RecordedScene",
            summary="A recording of a real camera, as the light that other cameras see.",
        ),
        Component(
            "renderer",
            "recorded",
            "tacos_worlds.recorded.renderer:RecordedLight",
            summary="Light of a recording on the pixels of other cameras, with the noise that it carries.",
        ),
        Component(
            "transform",
            "place-tags",
            "tacos_worlds.tags.place_tags:PlaceTags",
            summary="AprilTag or ArUco markers on the walls of any world, between its scene and a renderer.",
        ),
        Component(
            "scene",
            "grey-bars",
            "tacos_worlds.bench.grey_bars:GreyBars",
            summary="A test target of grey bars from black to white, to measure noise with.",
        ),
        Component(
            "scene",
            "light-box",
            "tacos_worlds.bench.light_box:LightBox",
            summary="An even white surface across the view, for flats and exposure series.",
        ),
        Component(
            "scene",
            "slanted-edges",
            "tacos_worlds.bench.slanted_edges:SlantedEdges",
            summary="Dark squares on white, a little turned: edges all over the field.",
        ),
        Component(
            "scene",
            "chessboard",
            "tacos_worlds.bench.chessboard:Chessboard",
            summary="A calibration board, tilted and turned.",
        ),
        Component(
            "scene",
            "colour-chart",
            "tacos_worlds.bench.colour_chart:ColourChart",
            summary="The 24 patches of a ColorChecker, by their reference values.",
        ),
        Component(
            "scene",
            "textured-target",
            "tacos_worlds.bench.textured_target:TexturedTarget",
            summary="A sheet full of detail of all sizes, standing still or passing by.",
        ),
        Component(
            "scene",
            "relief-target",
            "tacos_worlds.bench.relief_target:ReliefTarget",
            summary="Blocks of detail at several depths before a plain wall, passed sideways.",
        ),
    ]


@hookimpl
def tacos_commands() -> list[Command]:
    return commands.commands()
