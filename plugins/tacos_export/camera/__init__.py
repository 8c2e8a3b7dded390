"""Cameras as files: OpenCV, ROS and Kalibr for geometry, the units of EMVA 1288 for noise."""

from __future__ import annotations

from tacos_export.camera.description import CameraDescription, describe_cameras
from tacos_export.camera.files import write_camera_files

__all__ = ["CameraDescription", "describe_cameras", "write_camera_files"]
