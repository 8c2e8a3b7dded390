"""Folders of captures: real images, and what a simulator expects of them."""

from tacos_gap.captures.capture import Board, CaptureFolder, Noise, Objects, RealCapture
from tacos_gap.captures.reader import read_captures
from tacos_gap.captures.writer import CaptureWriter, WrittenCapture, write_captures

__all__ = [
    "Board",
    "CaptureFolder",
    "CaptureWriter",
    "Noise",
    "Objects",
    "RealCapture",
    "WrittenCapture",
    "read_captures",
    "write_captures",
]
