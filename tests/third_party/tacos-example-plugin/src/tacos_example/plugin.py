"""Lists the components of this package; imports none of them."""

from __future__ import annotations

from tacos_framework import Component, hookimpl


@hookimpl
def tacos_components() -> list[Component]:
    """What this package offers."""
    return [
        Component(
            "scene",
            "corridor",
            "tacos_example.corridor:Corridor",
            summary="A straight corridor with a checkerboard at its far end.",
        ),
        Component(
            "rig",
            "panorama",
            "tacos_example.panorama:PanoramaRig",
            summary="Cameras that look outwards, evenly around the agent.",
        ),
        Component(
            "renderer",
            "integrating-sphere",
            "tacos_example.integrating_sphere:IntegratingSphere",
            summary="Light that is the same everywhere, on exact geometry.",
            requires=("embreex",),
        ),
        Component(
            "effect",
            "haze",
            "tacos_example.haze:Haze",
            summary="Light lost on its way through hazy air.",
        ),
        Component(
            "sensor",
            "monochrome",
            "tacos_example.monochrome:MonochromeSensor",
            summary="Electrons of a monochrome sensor with shot and read noise.",
        ),
        Component(
            "transform",
            "point-tracks",
            "tacos_example.point_tracks:PointTracks",
            summary="The front end of visual odometry: corners followed from frame to frame.",
            requires=("cv2=opencv-python-headless",),
        ),
        Component(
            "control",
            "highlights",
            "tacos_example.highlights:Highlights",
            summary="Exposure time that keeps the brightest pixels just below full scale.",
        ),
        Component(
            "task",
            "checkerboard",
            "tacos_example.checkerboard:Checkerboard",
            summary="Share of frames in which a calibration target is found.",
            requires=("cv2=opencv-python-headless",),
        ),
        Component(
            "task",
            "free-distance",
            "tacos_example.free_distance:FreeDistance",
            summary="Learns to tell from an image how far the way ahead is free.",
        ),
        Component(
            "task",
            "heading",
            "tacos_example.heading:Heading",
            summary="How well the direction of motion is told from corners that move.",
            requires=("cv2=opencv-python-headless",),
        ),
        Component(
            "optimizer",
            "latin-hypercube",
            "tacos_example.latin_hypercube:LatinHypercube",
            summary="One draw in each stratum of each gene.",
        ),
        Component(
            "executor",
            "futures",
            "tacos_example.futures:FuturesExecutor",
            summary="Evaluation by concurrent.futures in spawned processes.",
        ),
        Component(
            "procedure",
            "preview",
            "tacos_example.preview:Preview",
            summary="A contact sheet of what a scene looks like.",
        ),
    ]
