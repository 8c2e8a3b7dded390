"""Arrays of frames, as programs save them: any type and byte order that holds a camera's digital numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from tacos_files.camera_images import read_frame
from tacos_framework.errors import UserError

FRAMES = arrays.arrays(np.uint16, st.tuples(st.integers(1, 6), st.integers(1, 6)))
ONE_FOLDER = [HealthCheck.function_scoped_fixture]


@settings(max_examples=60, deadline=None, suppress_health_check=ONE_FOLDER)
@given(
    frame=FRAMES,
    kind=st.sampled_from(["u2", "u4", "u8", "i4", "i8", "f4", "f8"]),
    order=st.sampled_from("<>"),
    by_columns=st.booleans(),
)
def test_byte_order_width_and_layout_change_no_number(
    frame: np.ndarray, kind: str, order: str, by_columns: bool, tmp_path: Path
) -> None:
    path = tmp_path / "frame.npy"
    np.save(path, np.asarray(frame, order + kind, order="F" if by_columns else "C"))
    read = read_frame(path, "frames")
    assert read.dtype == np.uint16
    assert read.dtype.isnative
    assert np.array_equal(read[..., 0], frame)


@settings(max_examples=40, deadline=None, suppress_health_check=ONE_FOLDER)
@given(
    frame=FRAMES,
    wrong=st.sampled_from([-1.0, 65536.0, 0.5, float("nan"), float("inf")]),
    order=st.sampled_from("<>"),
)
def test_one_number_that_no_camera_gives_is_refused(
    frame: np.ndarray, wrong: float, order: str, tmp_path: Path
) -> None:
    spoilt = frame.astype(order + "f8")
    spoilt[-1, -1] = wrong
    np.save(tmp_path / "frame.npy", spoilt)
    with pytest.raises(UserError, match=r"frame\.npy holds"):
        read_frame(tmp_path / "frame.npy", "frames")


@pytest.mark.parametrize(
    ("content", "said"),
    [(b"PK\x03\x04\x14\0", "a ZIP archive"), (b"v/1\x01\2\0", "OpenEXR"), (b"SIMPLE  =  T", "FITS")],
)
def test_formats_that_are_not_read_are_named(content: bytes, said: str, tmp_path: Path) -> None:
    (tmp_path / "frame.img").write_bytes(content)
    with pytest.raises(UserError, match=f"(?s)it is {said}, none of PNG.*Save it as one of these"):
        read_frame(tmp_path / "frame.img", "frames")
