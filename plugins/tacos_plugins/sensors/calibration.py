"""Noise calibrations of real cameras (paper, supplement, "Noise Model Calibration")."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from tacos_framework import Settings, UserError, check, find_file, read_yaml, setting, shipped_folder

Variance = Annotated[float, Field(ge=0)]


class Calibration(Settings):
    """Affine noise of one camera at one setting: ``variance = photon_dn * signal + thermal_dn2``."""

    title: str = setting(help="The measured camera, in one line.", min_length=1)
    source: str = setting(help="Source of the measurement, with its assumptions.", min_length=1)
    sensor: str = setting(help="The image sensor.")
    pixel_um: float = setting(help="Pitch of its photosites.", unit="um", gt=0)
    exposure_ms: float = setting(help="Exposure time.", unit="ms", gt=0)
    gain_db: float = setting(help="Gain.", unit="dB")
    bit_depth: int = setting(help="Bits per sample of the files measured.", unit="bit", ge=1, le=16)
    photon_dn: tuple[Variance, ...] = setting(
        help="Variance per signal, for R, G, B, or one value for mono.", unit="DN", min_length=1, max_length=3
    )
    thermal_dn2: tuple[Variance, ...] = setting(
        help="Variance without signal, for R, G, B, or one value for mono.",
        unit="DN^2",
        min_length=1,
        max_length=3,
    )
    responsivity_dn_per_lux_s: float = setting(
        help="Signal per focal-plane exposure at the calibrated gain.", unit="DN/(lux s)", gt=0
    )
    notes: tuple[str, ...] = setting((), help="Notes for users of the numbers.")

    @model_validator(mode="after")
    def _channels_agree(self) -> Calibration:
        channels = (len(self.photon_dn), len(self.thermal_dn2))
        if channels not in ((1, 1), (3, 3)):
            raise ValueError(
                f"photon_dn has {channels[0]} channels and thermal_dn2 {channels[1]}; 3 of each, or 1 of each"
            )
        return self


def load_calibration(name: str | Path, folder: Path | None = None) -> Calibration:
    """A shipped calibration by its name (``flea3_imx172``), or one of the user's by the path of its file.

    `folder`: the folder of the recipe: its paths start there and must not leave it. None lifts that.

    Raises `UserError` when there is none, or with all that is wrong with it.
    """
    shipped = shipped_folder("catalogs") / "noise"
    document = read_yaml(find_file(name, shipped, folder=folder, noun="noise calibration"))
    calibration, faults, _ = check(Calibration, document.data, document.where)
    if calibration is None:
        raise UserError(faults)
    return calibration
