"""Folders of captures: real images, and what a simulator expects of them."""

from tacos_gap.captures.capture import Board, CaptureFolder, Noise, Objects, RealCapture
from tacos_gap.captures.reader import read_captures
from tacos_gap.captures.writer import write_captures

__all__ = ["Board", "CaptureFolder", "Noise", "Objects", "RealCapture", "read_captures", "write_captures"]
