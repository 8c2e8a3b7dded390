"""Recordings that are one file: video, and ROS bags."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_files.videos import Video
from tacos_framework import Fault, UserError
from tacos_worlds.recorded.imports.found import FoundFrame, FoundRecording

_IMAGE = "sensor_msgs/msg/Image"
VIDEOS = (".mp4", ".avi", ".mkv", ".mov", ".webm")
_ENCODINGS: dict[str, type[np.unsignedinteger]] = {
    "mono8": np.uint8,
    "8UC1": np.uint8,
    "mono16": np.uint16,
    "16UC1": np.uint16,
}
_ENCODINGS |= {f"bayer_{order}8": np.uint8 for order in ("rggb", "bggr", "gbrg", "grbg")}
_ENCODINGS |= {f"bayer_{order}16": np.uint16 for order in ("rggb", "bggr", "gbrg", "grbg")}


def in_video(file: Path) -> FoundRecording:
    """Frames of a video, in grey: its coding has mixed colours and smoothed noise.

    Raises UserError when it cannot be read.
    """
    video = Video(file)
    frames = (FoundFrame(f"{i}", stamp, None, video.next_grey) for i, stamp in enumerate(video.stamp_ns))
    return FoundRecording("video, whose coding smooths noise", tuple(frames))


def in_bag(file: Path, topic: str) -> FoundRecording:
    """Images of one topic of a bag of ROS 1 or 2.

    Raises UserError when rosbags is not installed, no topic is named where several have images, or they are
    coded.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as missing:
        remedy = "pip install 'tacos-framework[rosbag]'"
        raise UserError(
            Fault(str(file), "is a ROS bag, and rosbags is not installed", "rosbags", remedy)
        ) from missing
    with AnyReader([file], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        images = [c for c in reader.connections if c.msgtype == _IMAGE and topic in ("", c.topic)]
        topics = sorted({each.topic for each in images})
        if len(topics) != 1:
            what = (
                f"has {len(topics)} topics of images: {', '.join(topics)}" if topics else "has no such images"
            )
            raise UserError(Fault(str(file), what, "one topic", "Name it by --topic."))
        frames = tuple(_messages(reader, images, str(file)))
    return FoundRecording(f"ROS bag, {topics[0]}", frames)


def _messages(reader: Any, images: Any, where: str) -> Iterator[FoundFrame]:
    for number, (connection, _, raw) in enumerate(reader.messages(connections=images)):
        message = reader.deserialize(raw, connection.msgtype)
        kind = _ENCODINGS.get(message.encoding)
        if kind is None:
            expected = ", ".join(_ENCODINGS)
            raise UserError(
                Fault(f"{where}: {connection.topic}", f"has images in {message.encoding}", expected)
            )
        stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        image = _image(message, np.dtype(kind))
        yield FoundFrame(f"{number:06d}.png", stamp_ns, None, lambda image=image: image)  # type: ignore[misc]


def _image(message: Any, kind: np.dtype[Any]) -> NDArray[Any]:
    order = kind.newbyteorder(">" if message.is_bigendian else "<")
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    return np.ascontiguousarray(rows[:, : message.width * kind.itemsize]).view(order).astype(kind)
