"""The one OpenGL context of a process, made on first use without a display (EGL)."""

from __future__ import annotations

import ctypes
import logging
import os
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_plugins.chosen_device import chosen_device
from tacos_plugins.renderers.moderngl.egl_devices import cuda_numbers, render_in_software

log = logging.getLogger(__name__)

OPENGL_VERSION = 330
"""Least version of OpenGL that is asked for: 3.3 core, which every driver since 2010 offers."""

# Machines without development packages lack the bare names, others lack the versioned ones.
_LIBRARIES = (("libGL.so.1", "libEGL.so.1"), ("libGL.so", "libEGL.so"), ("libOpenGL.so.0", "libEGL.so.1"))
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software rasterizer", "swiftshader")

_GL_TEXTURE_2D_ARRAY, _GL_RGBA, _GL_RGBA8, _GL_UNSIGNED_BYTE = 0x8C1A, 0x1908, 0x8058, 0x1401

_context: moderngl.Context | None = None
_library = ""
_owner_pid = 0


@dataclass(frozen=True)
class GlInfo:
    """The OpenGL in use: its strings, and its device, GPU or CPU."""

    renderer: str
    vendor: str
    version: str
    is_software: bool

    def __str__(self) -> str:
        kind = "software" if self.is_software else "GPU"
        return f"{self.renderer} ({kind}), OpenGL {self.version}"


def gl_context() -> moderngl.Context:
    """The context of this process.

    Raises `UserError` when no context can be made, saying what to install. Raises `RuntimeError` in a process
    forked from one that had a context: OpenGL would hang there.
    """
    global _context, _library, _owner_pid
    if _context is None:
        (_context, _library), _owner_pid = _create_context(), os.getpid()
        # Objects are released by their owners; those that are not must not pile up.
        _context.gc_mode = "auto"
        log.info("rendering with %s", _info_of(_context))
    elif _owner_pid != os.getpid():
        raise RuntimeError(
            "this process was forked from one with an OpenGL context, where rendering hangs; "
            "start it with the multiprocessing method 'spawn'"
        )
    return _context


def describe_gl() -> GlInfo:
    """The OpenGL of this process. Makes the context if there is none, and raises as it does."""
    return _info_of(gl_context())


def add_level(texture: moderngl.TextureArray, level: int, texels: NDArray[np.uint8]) -> None:
    """Add one mipmap level to a stack of RGBA textures, which moderngl itself cannot.

    `level`: number of the level, from 1. `texels`: (layers, rows, columns, 4) uint8.
    """
    gl_context()
    layers, rows, columns, _ = texels.shape
    texels = np.ascontiguousarray(texels)
    texture.use(0)
    write = ctypes.CDLL(_library).glTexImage3D
    write.restype = None
    write.argtypes = [ctypes.c_uint] + [ctypes.c_int] * 6 + [ctypes.c_uint] * 2 + [ctypes.c_void_p]
    size = (columns, rows, layers)
    pixels = (_GL_RGBA, _GL_UNSIGNED_BYTE, texels.ctypes.data)
    write(_GL_TEXTURE_2D_ARRAY, level, _GL_RGBA8, *size, 0, *pixels)


def flush() -> None:
    """Let all that was asked for begin, without waiting for it."""
    gl_context()
    begin = ctypes.CDLL(_library).glFlush
    begin.restype, begin.argtypes = None, []
    begin()


def _info_of(context: moderngl.Context) -> GlInfo:
    renderer = context.info["GL_RENDERER"]
    return GlInfo(
        renderer=renderer,
        vendor=context.info["GL_VENDOR"],
        version=context.info["GL_VERSION"],
        is_software=any(name in renderer.lower() for name in _SOFTWARE),
    )


def _create_context() -> tuple[moderngl.Context, str]:
    """The context, and the library its functions are in."""
    reasons = []
    chosen = chosen_device()
    if chosen == "cpu":
        render_in_software()
    for libgl, libegl in _LIBRARIES:
        try:
            settings: dict[str, Any] = {"backend": "egl", "libgl": libgl, "libegl": libegl}
            if isinstance(chosen, int):
                settings["device_index"] = cuda_numbers(libegl).index(chosen)
        except (OSError, ValueError):
            reasons.append(f"{libegl}: it has no device that CUDA calls {chosen}")
            continue
        try:
            context = moderngl.create_context(require=OPENGL_VERSION, standalone=True, **settings)
        # moderngl and glcontext raise bare Exception for every failure to load or to create.
        except Exception as error:  # noqa: BLE001
            reasons.append(f"{libegl}: {error}")
        else:
            return context, libgl
    if isinstance(chosen, int) and all("that CUDA calls" in reason for reason in reasons):
        where, expected = f"--device {chosen}", "cpu, or a GPU that OpenGL reaches as well"
        remedy = "Leave it out, or install the OpenGL libraries of the GPU's driver (libnvidia-gl)."
        raise UserError(Fault(where, f"OpenGL does not reach GPU {chosen}: {reasons[0]}", expected, remedy))
    raise UserError(
        Fault(
            where="renderer.moderngl",
            what=f"no OpenGL {OPENGL_VERSION // 100}.{OPENGL_VERSION // 10 % 10} context without a display"
            f" ({'; '.join(dict.fromkeys(reasons))})",
            expected="EGL with a GPU driver or Mesa's software renderer",
            remedy="Install the Debian or Ubuntu packages libegl1 libgl1-mesa-dri libegl-mesa0 libgl1, or use"
            " renderer.analytic, which needs no OpenGL.",
        )
    )
