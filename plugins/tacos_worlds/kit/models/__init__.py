"""Content of files of triangles, on its way to the parts of a world.

``model``     surfaces, looks and lamps of a file, in its own axes
``cutouts``   surfaces cut to where they hide what is behind, with ``mask_outlines`` and ``uv_clipping``
``hulls``     collision hulls left out
``patch``     surfaces in metres with z up
``tints``     colours of vertices, with ``atlas``
``normals``   normals of surfaces that come without
"""
