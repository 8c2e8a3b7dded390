"""Compiles the shaders of this package."""

from __future__ import annotations

from importlib.resources import files

import moderngl


def compile_program(
    context: moderngl.Context, vertex: str, fragment: str, defines: tuple[str, ...] = ()
) -> moderngl.Program:
    """The program of two shader files of this package, with names defined for their ``#ifdef``."""
    return context.program(
        vertex_shader=shader_source(vertex, defines), fragment_shader=shader_source(fragment, defines)
    )


def shader_source(name: str, defines: tuple[str, ...] = ()) -> str:
    """The text of a shader file: ``//include FILE`` replaced, definitions after the version line."""
    folder = files(__package__) / "shaders"
    lines = []
    for line in (folder / name).read_text(encoding="utf-8").splitlines():
        if line.startswith("//include "):
            lines.append((folder / line.split()[1]).read_text(encoding="utf-8"))
        else:
            lines.append(line)
        if line.startswith("#version"):
            lines += [f"#define {word}" for word in defines]
    return "\n".join(lines)
