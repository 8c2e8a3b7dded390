"""``tacos export``."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from tacos_framework import DONE, Command, Fault, UserError
from tacos_view.commands import add_sets, read_sets, said_meanwhile

FORMATS = ("coco", "kitti", "euroc", "tum", "yolo", "bop", "nerf", "colmap", "png16", "exr")


def commands() -> list[Command]:
    return [Command("export", "write a camera or rendered data for other programs", _arguments, _export)]


def _arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    camera = actions.add_parser("camera", help="calibration files for OpenCV, ROS and Kalibr, and the noise")
    camera.add_argument("recipe", metavar="RUN", help="results folder of a study, or a recipe")
    camera.add_argument(
        "--simulated", action="store_true", help="the image as simulated, where the rig bins photosites"
    )
    dataset = actions.add_parser("dataset", help="rendered frames with depth, poses and labels")
    dataset.add_argument("recipe", metavar="RECIPE", help="a recipe, a results folder, or a scene")
    dataset.add_argument("--format", choices=FORMATS, required=True, help="the format")
    dataset.add_argument("--frames", metavar="N", type=int, default=100, help="how many frames [100]")
    dataset.add_argument("--seed", metavar="N", type=int, help="which world, instead of the recipe's seed")
    dataset.add_argument(
        "--encoding",
        choices=("srgb", "camera"),
        help="8-bit images as photographs, or the camera's own numbers [srgb without a tone curve]",
    )
    for action, folder in ((camera, "camera"), (dataset, "dataset")):
        action.add_argument("--camera", metavar="NAME", help="a product, or a camera of the run [designed]")
        add_sets(action)
        action.add_argument("--out", metavar="DIR", type=Path, default=Path(folder), help=f"[{folder}]")


def _export(arguments: argparse.Namespace) -> int:
    return _camera(arguments) if arguments.action == "camera" else _dataset(arguments)


def _camera(arguments: argparse.Namespace) -> int:
    from tacos_export.camera import describe_cameras, write_camera_files
    from tacos_view.setup import set_up

    setup = set_up(arguments.recipe, arguments.camera, sets=read_sets(arguments.sets))
    described = describe_cameras(setup, simulated=arguments.simulated)
    written, limitations = write_camera_files(arguments.out, described)
    print(f"{setup.camera.title}:")
    for path in written:
        print(f"  {path}")
    _tell(limitations, setup.camera.assumed)
    return DONE


def _dataset(arguments: argparse.Namespace) -> int:
    from tacos_export.dataset import export_dataset
    from tacos_framework import Plugins
    from tacos_view.setup import set_up

    if arguments.frames < 1:
        raise UserError(Fault("--frames", f"{arguments.frames} frames are none", "1 or more"))
    plugins = Plugins.discover()
    written = _Written(arguments.frames)
    with said_meanwhile(plugins):
        setup = set_up(arguments.recipe, arguments.camera, sets=read_sets(arguments.sets), plugins=plugins)
        notes = export_dataset(
            setup,
            arguments.out,
            arguments.format,
            frames=arguments.frames,
            seed=arguments.seed,
            encoding=arguments.encoding,
            progress=written,
        )
    print(f"{written.count} frames of {setup.camera.title} as {arguments.format}: {arguments.out}")
    _tell(notes, setup.camera.assumed)
    return DONE


class _Written:
    """Counts the frames that are written; says how many, and how long the rest may take, now and then."""

    def __init__(self, frames: int) -> None:
        from tacos_framework import Pace

        self._pace, self._said_s = Pace("Frames", frames), time.monotonic()

    @property
    def count(self) -> int:
        return self._pace.done

    def __call__(self, count: int) -> None:
        from tacos_framework import LONGEST_SILENCE_S

        self._pace.done = count
        if time.monotonic() - self._said_s >= LONGEST_SILENCE_S:
            print(self._pace, file=sys.stderr)
            self._said_s = time.monotonic()


def _tell(notes: list[str], assumed: tuple[str, ...]) -> None:
    for note in notes:
        print(f"note: {note}")
    if assumed:
        print(f"note: not set: {', '.join(assumed)}; using the middle of its range")
