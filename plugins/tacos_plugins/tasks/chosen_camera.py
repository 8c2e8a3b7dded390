"""The camera of a rig that a task of one camera looks through."""

from __future__ import annotations

from tacos_framework import Fault, FrameBatch, UserError, did_you_mean


def camera_index(frames: FrameBatch, name: str | None, *, where: str) -> int:
    """Index of the camera of this name; of the first where none is named.

    `name`: what the setting ``camera`` of the task says. `where`: the task, for the message.

    Raises `UserError` when the rig has no such camera.
    """
    names = [view.camera.name for view in frames.capture.views]
    if name is None:
        return 0
    if name not in names:
        expected = f"one of {', '.join(names)}"
        raise UserError(Fault(where, f"camera is {name!r}", expected, did_you_mean(name, names)))
    return names.index(name)
