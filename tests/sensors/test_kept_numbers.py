"""Normal numbers of frames are drawn once, and are the same as if they were drawn anew."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_plugins.sensors import kept_numbers
from tacos_plugins.sensors.gaussian import NormalNumbers
from tacos_plugins.sensors.kept_numbers import KeptNumbers
from tacos_plugins.sensors.noise import add_noise

FRAME = 4096
FRAME_BYTES = 4 * FRAME


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The keys of frames that were really drawn."""
    keys: list[bytes] = []

    class Counted(NormalNumbers):
        def fill(self, out: np.ndarray) -> None:
            keys.append(self.key)
            super().fill(out)

    monkeypatch.setattr(kept_numbers, "NormalNumbers", Counted)
    return keys


def of(kept: KeptNumbers, seed: int, count: int = FRAME) -> np.ndarray:
    numbers = np.empty(count, np.float32)
    kept.of(np.random.default_rng(seed), count).fill(numbers)
    return numbers


def anew(seed: int, count: int = FRAME) -> np.ndarray:
    numbers = np.empty(count, np.float32)
    NormalNumbers(np.random.default_rng(seed)).fill(numbers)
    return numbers


def test_a_frame_is_drawn_once_and_has_the_numbers_it_would_have_anew(drawn: list[bytes]):
    kept = KeptNumbers(8 * FRAME_BYTES)
    for seed in (1, 2, 1, 2, 1):
        np.testing.assert_array_equal(of(kept, seed), anew(seed))
    assert len(drawn) == 2


def test_frames_of_another_size_are_other_frames(drawn: list[bytes]):
    kept = KeptNumbers(8 * FRAME_BYTES)
    of(kept, 1)
    np.testing.assert_array_equal(of(kept, 1, 2 * FRAME), anew(1, 2 * FRAME))
    assert len(drawn) == 2


def test_where_there_is_no_room_a_frame_is_drawn_each_time(drawn: list[bytes]):
    kept = KeptNumbers(2 * FRAME_BYTES - 1)
    for seed in (1, 2, 1, 2):
        np.testing.assert_array_equal(of(kept, seed), anew(seed))
    assert len(drawn) == 3


@pytest.mark.parametrize("side", [8, 400])
def test_noise_is_the_same_bits_with_numbers_kept(side: int):
    samples = np.full((side, side, 3), 100.0, np.float32)
    kept = KeptNumbers(1 << 24)
    noisy = [np.empty_like(samples) for _ in range(3)]
    for out, store in zip(noisy, (None, kept, kept), strict=True):
        add_noise(
            samples,
            out,
            black_level_dn=16.0,
            photon_dn=np.float32(0.24),
            thermal_dn2=np.float32(1.8),
            rng=np.random.default_rng(9),
            kept=store,
        )
    np.testing.assert_array_equal(noisy[0], noisy[1])
    np.testing.assert_array_equal(noisy[0], noisy[2])
