"""glTF, OBJ, PLY and STL files from outside, read into :class:`tacos_worlds.kit.models.model.Model`.

``read``          the door: a file to a model
``gltf``          glTF, by ``gltf_buffers``, ``gltf_primitives``, ``gltf_skins`` and ``gltf_notes``
``obj``           OBJ, with libraries of materials by ``mtl`` and ``mtl_skins``
``ply``, ``stl``  those
``packed``        meshopt and KTX2, by optional libraries
``polygons``      polygons as triangles
``precision``     what single precision has already rounded
``references``    files and pictures that a file names
"""

from __future__ import annotations

from tacos_worlds.kit.mesh_files.damage import content_faults
from tacos_worlds.kit.mesh_files.read import SUFFIXES, read_model

__all__ = ["SUFFIXES", "content_faults", "read_model"]
