"""Cameras and rendered data in the formats of other programs: ``tacos export``.

``conventions`` states axes, units, pixel centres and depth; all writers hold to it.

==================  ==========================================================================================
``conventions``     one statement of the conventions, and the functions that carry them out
``camera``          cameras of a rig as files of OpenCV, ROS and Kalibr, and their noise in the units of EMVA
``dataset``         frames as COCO, KITTI, EuRoC, TUM, YOLO, BOP, NeRF, COLMAP, 16-bit PNG and EXR
``commands``        ``tacos export camera`` and ``tacos export dataset``
==================  ==========================================================================================
"""

from __future__ import annotations
