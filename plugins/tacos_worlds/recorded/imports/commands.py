"""``tacos recordings``."""

from __future__ import annotations

import argparse
from pathlib import Path

from tacos_framework import DONE, Command, Fault, UserError


def commands() -> list[Command]:
    return [Command("recordings", "recordings of real cameras: import them", _arguments, _recordings)]


def _arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    imported = actions.add_parser(
        "import", help="make a folder of frames, EuRoC, TUM, KITTI, a video or a ROS bag one of ours"
    )
    imported.add_argument(
        "source", metavar="SOURCE", type=Path, help="a folder, a video, or a bag of ROS 1 or 2"
    )
    imported.add_argument("--out", metavar="DIR", type=Path, required=True, help="the folder, new or empty")
    imported.add_argument(
        "--exposure-ms", metavar="MS", type=float, help="exposure of frames that state none"
    )
    imported.add_argument(
        "--topic", metavar="TOPIC", default="", help="topic of the images in a bag with several"
    )


def _recordings(arguments: argparse.Namespace) -> int:
    from tacos_worlds.recorded.imports.folders import in_folder
    from tacos_worlds.recorded.imports.streams import VIDEOS, in_bag, in_video
    from tacos_worlds.recorded.imports.writing import write_recording

    source: Path = arguments.source
    if not source.exists():
        raise UserError(Fault(str(source), "there is no such file or folder", "a recording"))
    if source.suffix == ".bag" or (source / "metadata.yaml").is_file():
        found = in_bag(source, arguments.topic)
    elif source.suffix.lower() in VIDEOS:
        found = in_video(source)
    elif source.is_dir():
        found = in_folder(source)
    else:
        raise UserError(
            Fault(str(source), "is no recording", f"a folder, a bag, or a video ({', '.join(VIDEOS)})")
        )
    print("\n".join(write_recording(found, arguments.out, arguments.exposure_ms)))
    return DONE
