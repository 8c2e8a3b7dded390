"""What is left out where it shows nothing, beside doing it all the same."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from tacos_framework.values import Light
from tacos_plugins.renderers.light.probes import (
    face_camera,
    face_rotations,
    may_show,
    paint_light,
    pixel_rays,
)
from tacos_plugins.renderers.moderngl.culling import looked_up

metres = st.floats(-4, 4)


@st.composite
def lights(draw) -> Light:
    position = np.array([draw(metres), draw(metres), draw(metres)])
    if draw(st.booleans()):
        return Light(position, np.ones(3), radius_m=draw(st.floats(0.02, 0.8)))
    angle = draw(st.floats(0, np.pi))
    normal = np.array([np.sin(angle), 0, -np.cos(angle)])
    u = np.array([0.0, draw(st.floats(0.05, 1)), 0.0])
    v = np.cross(normal, [0.0, draw(st.floats(0.05, 1)), 0.0])
    return Light(position, np.ones(3), normal=normal, half_u_m=u, half_v_m=v)


@settings(max_examples=150, deadline=None)
@given(light=lights(), number=st.integers(0, 5))
def test_a_light_that_is_painted_into_a_face_may_show_there(light, number):
    rotation = face_rotations()[number]
    rays = pixel_rays(face_camera()) @ rotation.T
    face, depth = np.zeros((*rays.shape[:2], 3), np.float32), np.full(rays.shape[:2], 1e6, np.float32)
    if np.linalg.norm(light.position_m) > 1e-3:
        paint_light(face, depth, rays, np.zeros(3), light)
        assert may_show(rotation, light.position_m.astype(np.float64), light) or not face.any()


@given(
    surface=arrays.arrays(np.int32, (5, 7), elements=st.integers(0, 9)),
    table=arrays.arrays(np.int32, 10, elements=st.integers(0, 1000)),
)
def test_object_ids_looked_up_in_runs_are_those_of_each_pixel(surface, table):
    np.testing.assert_array_equal(looked_up(table, surface.astype(np.float32)), table[surface])
