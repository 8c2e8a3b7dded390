"""Costs of a camera besides light: time for a frame, data, power, mass and price."""

from __future__ import annotations

from tacos_framework import CURRENCIES
from tacos_plugins.rigs.lens import LensPart
from tacos_plugins.rigs.mounted_camera import MountSettings, ReadOutVariables
from tacos_plugins.rigs.priced_part import PRICE, total_prices
from tacos_plugins.rigs.product import ProductPart
from tacos_plugins.rigs.sensor_part import SensorPart, bits_of

COST_UNITS = {
    "image_width_px": "px",
    "image_height_px": "px",
    "frame_rate_fps": "1/s",
    "exposure_max_ms": "ms",
    "exposure_min_us": "us",
    "pixel_rate_mpx_s": "Mpx/s",
    "bandwidth_mbit_s": "Mbit/s",
    "power_w": "W",
    "mass_g": "g",
    "f_number": "1",
    **{f"{PRICE}{currency}": currency.upper() for currency in CURRENCIES},
}
"""Names and units of what :func:`derived_costs` gives."""


def derived_costs(
    variables: ReadOutVariables,
    settings: MountSettings,
    *,
    cameras: int = 1,
    product: ProductPart | None = None,
    lens: LensPart | None = None,
) -> dict[str, float]:
    """The quantities of :data:`COST_UNITS` that are known, of all cameras of a rig together.

    Rates and exposures are those of each camera at its fastest; ``exposure_max_ms`` is the time of a frame.

    `product`: the whole camera, which has all cameras of the rig in it. `lens`: the lens of each camera,
    where one was chosen.
    """
    sensor, image = variables.sensor, variables.read_out
    found: dict[str, float | None] = {
        "image_width_px": image.width_px,
        "image_height_px": image.height_px,
        "exposure_min_us": sensor.min_exposure_us,
        "power_w": _times(cameras if product is None else 1, sensor.power_w),
    }
    if product is not None:
        parts = [product.prices]
        found |= {"mass_g": product.mass_g, "f_number": product.f_number}
    else:
        parts = [sensor.prices, *([] if lens is None else [lens.prices])] * cameras
        found["mass_g"] = _times(cameras, _sum(sensor.camera_mass_g, None if lens is None else lens.mass_g))
    if product is not None or lens is not None:  # without a lens, no price and no mass is that of a camera
        found |= {f"{PRICE}{name}": total for name, total in total_prices(parts, settings.per_euro).items()}
    rate = frame_rate_fps(sensor, rows=sensor.region(1, variables.roi_height).height_px, product=product)
    if rate is not None:
        pixels_s = cameras * image.width_px * image.height_px * rate
        bits = settings.bits_per_pixel or bits_of(sensor.bit_depth)
        found |= {
            "frame_rate_fps": rate,
            "exposure_max_ms": 1e3 / rate,
            "pixel_rate_mpx_s": pixels_s * 1e-6,
            "bandwidth_mbit_s": _times(pixels_s * 1e-6, bits),
        }
    return {name: float(value) for name, value in found.items() if value is not None}


def frame_rate_fps(sensor: SensorPart, *, rows: int, product: ProductPart | None = None) -> float | None:
    """Most frames per second: as the maker of a product states, else the faster of stated and computed.

    A region of interest of fewer rows is read faster where line time and blanking are known. What a product
    is stated with counts at every size, as its link may be what limits it.

    `rows`: rows of photosites that are read of each frame.

    >>> imx290 = SensorPart(width_px=1920, height_px=1080, pixel_um=2.9, row_time_us=14.81, frame_lines=1125)
    >>> [round(frame_rate_fps(imx290, rows=rows), 1) for rows in (1080, 540)]
    [60.0, 115.4]
    """
    if product is not None and product.max_fps is not None:
        return product.max_fps
    rates = [rate for rate in (sensor.max_fps, sensor.frame_rate_fps) if rate is not None]
    if sensor.row_time_us is not None and sensor.frame_lines is not None:
        rates.append(1e6 / (sensor.row_time_us * (rows + sensor.frame_lines - sensor.height_px)))
    return max(rates, default=None)


def _times(factor: float, value: float | None) -> float | None:
    return None if value is None else factor * value


def _sum(*values: float | None) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if len(known) == len(values) else None
