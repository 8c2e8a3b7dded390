"""Mitsuba, with the variant that computes where the user wants it."""

from __future__ import annotations

from types import ModuleType
from typing import Literal

from tacos_framework import Fault, UserError

Backend = Literal["scalar", "llvm", "cuda"]
"""Ray by ray on the processor; many rays at once, compiled by LLVM; on an NVIDIA GPU."""

_VARIANTS: dict[Backend, str] = {"scalar": "scalar_rgb", "llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}
_NEEDS: dict[Backend, str] = {
    "scalar": "Mitsuba's variant scalar_rgb",
    "llvm": "LLVM 19 or later as a shared library, named by DRJIT_LIBLLVM_PATH where it is not found",
    "cuda": "an NVIDIA driver with OptiX",
}

_LEAST_LLVM = (19,)
"""LLVM 15 ends the whole process, unable to compile what Dr.Jit gives it on processors with AVX-512."""


def mitsuba_for(backend: Backend) -> ModuleType:
    """The module `mitsuba`, set to compute with `backend`.

    The variant is a setting of the whole process in Mitsuba, so it is set anew before each use.

    Raises `UserError` when Mitsuba is not installed, or cannot compute with `backend` here.
    """
    try:
        import mitsuba
    except ModuleNotFoundError as error:
        if error.name not in ("mitsuba", "drjit"):
            raise
        raise UserError(
            Fault(
                "renderer.mitsuba",
                "the package mitsuba is not installed",
                remedy="pip install tacos-framework[mitsuba]",
            )
        ) from error
    try:
        mitsuba.set_variant(_VARIANTS[backend])
        mitsuba.load_dict({"type": "constant"})  # the backend itself is loaded with the first object
    except (ImportError, RuntimeError) as error:
        raise UserError(_unusable(backend, str(error))) from error
    if backend == "llvm" and (found := _llvm_version()) < _LEAST_LLVM:
        raise UserError(_unusable(backend, f"it finds LLVM {'.'.join(map(str, found))}"))
    return mitsuba


def _llvm_version() -> tuple[int, ...]:
    from drjit import detail

    return tuple(detail.llvm_version())


def _unusable(backend: Backend, reason: str) -> Fault:
    return Fault(
        "renderer.mitsuba",
        f"Mitsuba cannot compute with the backend {backend!r} here: {reason}",
        _NEEDS[backend],
        "Set backend: scalar, which works on any processor.",
    )
