"""Files of triangles (glTF, OBJ, PLY) from outside, checked before trimesh is given them.

``read``        the door: a file to a scene
``gltf``        whether a glTF file holds what it promises, in entries of ``gltf_shapes``
``plain``       the same of OBJ and PLY files
``mtl``         libraries of materials of OBJ files
``references``  files and pictures that a file names
"""

from __future__ import annotations

from tacos_worlds.kit.mesh_files.read import SUFFIXES, MeshFile, read_mesh_file

__all__ = ["SUFFIXES", "MeshFile", "read_mesh_file"]
