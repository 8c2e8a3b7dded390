"""What others call the quantities of a camera and of a study, for suggestions where a name is unknown."""

from __future__ import annotations

from collections.abc import Collection, Mapping

SYNONYMS: Mapping[str, tuple[str, ...]] = {
    "iso": ("gain_db",),
    "sensitivity": ("gain_db", "responsivity_dn_per_lux_s"),
    "amplification": ("gain_db",),
    "shutter": ("exposure_ms", "readout_us"),
    "integration": ("exposure_ms",),
    "aperture": ("f_number",),
    "fnumber": ("f_number",),
    "fstop": ("f_number",),
    "fov": ("hfov_deg", "focal_length_mm"),
    "hfov": ("hfov_deg", "focal_length_mm"),
    "vfov": ("vfov_deg", "focal_length_mm"),
    "zoom": ("focal_length_mm",),
    "efl": ("focal_length_mm",),
    "lux": ("illumination_lux",),
    "brightness": ("illumination_lux", "responsivity_dn_per_lux_s"),
    "light": ("illumination_lux",),
    "tilt": ("pitch_deg",),
    "elevation": ("pitch_deg",),
    "pan": ("yaw_deg",),
    "heading": ("yaw_deg",),
    "imager": ("sensor",),
    "chip": ("sensor",),
    "resolution": ("sensor", "binning", "megapixels"),
    "downsample": ("binning", "sensor_binning"),
    "downscale": ("binning", "sensor_binning"),
    "binning": ("sensor_binning",),
    "bin": ("sensor_binning",),
    "roi": ("roi_height",),
    "crop": ("roi_height",),
    "window": ("roi_height",),
    "focus": ("focus_m",),
    "defocus": ("focus_m",),
    "pitch_um": ("pixel_um",),
    "pixel_size": ("pixel_um",),
    "bits": ("bit_depth",),
    "fps": ("frame_rate_hz",),
    "steps": ("frames", "generations", "evaluations"),
    "trials": ("evaluations",),
    "budget": ("evaluations", "generations"),
    "iterations": ("generations", "evaluations"),
    "lr": ("learning_rate",),
    "jobs": ("workers",),
    "threads": ("workers",),
    "processes": ("workers",),
    "eye_distance": ("baseline_m",),
    "separation": ("baseline_m",),
}
"""Words in lower case, and the names here that may be meant, the likeliest first."""


def meant(given: str, known: Collection[str]) -> str | None:
    """The known name that somebody means by a word of another field, or None.

    Examples
    --------
    >>> meant("ISO", ["exposure_ms", "gain_db"])
    'gain_db'
    >>> meant("shutter_speed_us", ["exposure_ms", "gain_db"])
    'exposure_ms'
    """
    word = given.lower().rpartition(".")[2].replace("-", "_")
    parts = (word, word.replace("_", ""), *word.split("_"))
    candidates = (name for part in parts for name in SYNONYMS.get(part, ()))
    return next((name for name in candidates if name in known), None)
