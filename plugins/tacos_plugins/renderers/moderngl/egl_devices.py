"""The devices EGL can render on, and which of them CUDA calls by which number: both count on their own."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

_EGL_CUDA_DEVICE_NV = 0x323A  # of the extension EGL_NV_device_cuda
_MOST_DEVICES = 64
_MESA = Path("/usr/share/glvnd/egl_vendor.d/50_mesa.json")


def cuda_numbers(libegl: str) -> list[int | None]:
    """For each device of EGL, in its order, the number CUDA has for it; None for one that is none of CUDA's.

    Raises `OSError` when the library cannot be loaded, or cannot list devices.
    """
    address = ctypes.CDLL(libegl).eglGetProcAddress
    address.restype, address.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    query, attribute = address(b"eglQueryDevicesEXT"), address(b"eglQueryDeviceAttribEXT")
    if not query or not attribute:
        raise OSError(f"{libegl} cannot list devices")
    list_devices = ctypes.CFUNCTYPE(
        ctypes.c_uint, ctypes.c_int, ctypes.POINTER(ctypes.c_void_p), ctypes.POINTER(ctypes.c_int)
    )(query)
    ask = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(ctypes.c_ssize_t))(
        attribute
    )
    devices, count = (ctypes.c_void_p * _MOST_DEVICES)(), ctypes.c_int()
    if not list_devices(_MOST_DEVICES, devices, ctypes.byref(count)):
        raise OSError(f"{libegl} lists no devices")
    numbers: list[int | None] = []
    for device in devices[: count.value]:
        number = ctypes.c_ssize_t()
        known = ask(device, _EGL_CUDA_DEVICE_NV, ctypes.byref(number))
        numbers.append(number.value if known else None)
    return numbers


def render_in_software() -> None:
    """Let the OpenGL that is loaded from now on in this process be Mesa's on the CPU."""
    os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
    if _MESA.exists():
        os.environ["__EGL_VENDOR_LIBRARY_FILENAMES"] = str(_MESA)
