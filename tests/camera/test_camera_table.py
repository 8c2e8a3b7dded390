"""A camera in a notebook: its figures with their units."""

from __future__ import annotations

import re

from tacos_framework.values import Camera, Rig
from tacos_framework.values.camera import Electrons

LEFT = Camera("left <1>", 640, 480, 3.0, 2.4, binning=2.0)
RIGHT = Camera("right", 640, 480, 6.0, 2.4, electrons=Electrons("IMX <b>", 0.5, 10_000.0, None, 3.2))


def rows(html: str) -> list[list[str]]:
    return [re.findall("<td>(.*?)</td>", row) for row in re.findall("<tr>(.*?)</tr>", html)]


def test_a_camera_is_a_table_of_what_is_known_of_it():
    assert rows(LEFT._repr_html_()) == [
        ["", "left &lt;1&gt;"],
        ["image [px]", "640 x 480"],
        ["photosite pitch [um]", "3"],
        ["binning [1]", "2"],
        ["focal length [mm]", "2.4"],
        ["focal length [px]", "400"],
        ["field of view [deg]", "77.3 x 61.9"],
        ["position on the agent, x y z [m]", "0 0 0"],
        ["looks along, x y z [1]", "0 0 1"],
    ]


def test_a_rig_has_its_cameras_side_by_side_and_leaves_empty_what_one_lacks():
    found = {name: values for name, *values in rows(Rig((LEFT, RIGHT))._repr_html_())}
    assert found["binning [1]"] == ["2", ""]
    assert found["image sensor"] == ["", "IMX &lt;b&gt;"]
    assert found["quantum efficiency [1]"] == ["", "0.5"]
    assert found["dark current [e-/s]"] == ["", "3.2"]
    assert "read noise [e-]" not in found
