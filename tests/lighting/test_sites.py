"""Where light is computed for a vertex."""

from __future__ import annotations

import numpy as np
from small_worlds import matte, world

from tacos_framework.values import MeshPart
from tacos_plugins.lighting import bake_indirect


def test_sites_of_rounded_edges_lie_outside():
    # A cube whose faces share their corners, so that normals point along the diagonals: under an even sky of
    # luminance 1 each corner sees its whole hemisphere, an illuminance of pi.
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
    cube = MeshPart(0.25 * corners, corners / np.sqrt(3), np.zeros((8, 2)), triangles, 0, 0)
    (lux,) = bake_indirect(world([cube], [matte(0.5)], indirect_lux=None, ambient_cd_m2=1.0))
    np.testing.assert_allclose(lux, np.pi, rtol=0.05)
