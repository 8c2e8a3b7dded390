"""The simulator on plain arrays: expected light, effects at their places, noise, rounding, clipping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import acts_after_noise, formation_order
from tacos_framework.values.image_geometry import ContextMissing
from tacos_gap.captures import Capture

LIGHT = ("scene", "optics", "exposure")


def simulate(
    capture: Capture, effects: Sequence[Any], rng: np.random.Generator, frames: int | None = None
) -> NDArray[np.float32]:
    """Frames the simulator would have given instead of the real ones.

    Parameters
    ----------
    capture
        Supplies the expected values, the noise and the levels.
    effects
        Effect components, in any order; each acts at its own stage.
    rng
        Draws the noise. The same generator state gives noise that is comparable between hypotheses.
    frames
        How many; as many as are real by default.

    Returns
    -------
    NDArray
        (N, H, W, C) float32 values of the file: whole numbers within its levels [DN].
    """
    assert capture.expected_dn is not None
    count = frames or capture.frames
    context = capture.context
    noise_rng, effect_rng = rng.spawn(2)
    ordered = sorted(effects, key=lambda effect: formation_order(type(effect)))

    def act(image: NDArray[np.float32], chosen: list[Any]) -> NDArray[np.float32]:
        for effect in chosen:
            image = applied(effect, image, capture, effect_rng)
        return image

    light = capture.expected_dn[:count] - np.float32(context.black_level_dn)
    light = act(light, [e for e in ordered if e.stage in ("scene", "optics")])
    exposing = [e for e in ordered if e.stage == "exposure"]
    if exposing and len(light) == 1:
        light = np.repeat(light, count, axis=0)
    light = act(light, exposing)
    signal = light + np.float32(context.black_level_dn)
    signal = act(signal, [e for e in ordered if e.stage == "pixel" and not acts_after_noise(type(e))])
    scale = float(np.prod([getattr(e, "photon_scale", 1.0) for e in ordered]))
    variance = capture.noise.variance_dn2(signal - np.float32(context.black_level_dn), scale)
    samples = noise_rng.standard_normal((count, *signal.shape[1:]), dtype=np.float32)
    samples *= np.sqrt(variance)
    samples += signal
    samples = act(
        samples, [e for e in ordered if e.stage in ("pixel", "readout") and acts_after_noise(type(e))]
    )
    files = _digitise(samples, context.white_level_dn)
    processing = [e for e in ordered if e.stage in ("isp", "codec")]
    return _digitise(act(files, processing), context.white_level_dn) if processing else files


def applied(
    effect: Any, image: NDArray[np.float32], capture: Capture, rng: np.random.Generator
) -> NDArray[np.float32]:
    """The image with an effect; without it where too little is known of the capture, as motion of a still."""
    try:
        return np.asarray(effect.on_array(image, geometry=capture.geometry, context=capture.context, rng=rng))
    except ContextMissing:
        return image


def _digitise(samples: NDArray[np.float32], white_level_dn: float) -> NDArray[np.float32]:
    return np.clip(np.rint(samples), 0, white_level_dn).astype(np.float32, copy=False)
