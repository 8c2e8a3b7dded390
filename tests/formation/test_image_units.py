"""Physical settings become those of an image; binning is counted in; what cannot be had is said."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework.camera.units import image_units_per
from tacos_framework.errors import CandidateFailed
from tacos_framework.formation import in_image_units
from tacos_framework.settings import Settings, physical, setting
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_gap.answer.physical_settings import physical_settings_of


class Config(Settings):
    """An effect's settings of every sort."""

    radius_px: float = setting(0.0, help="Radius.", unit="px", ge=0, le=100)
    radius_um: float | None = physical("radius_px", help="The same on the sensor.", unit="um", ge=0)
    sigma_dn: float = setting(0.0, help="Noise.", unit="DN", averaging="photosites", ge=0)
    sigma_e: float | None = physical("sigma_dn", help="The same in charge.", unit="e-", ge=0)
    rows_dn: float = setting(0.0, help="Rows.", unit="DN", averaging="lines", ge=0)
    level_dn: float | None = setting(None, help="Level.", unit="DN", with_pedestal=True, gt=0)
    level_e: float | None = physical("level_dn", help="The same in charge.", unit="e-", gt=0)
    length_px: float = setting(0.0, help="Path.", unit="px", ge=0)
    speed_deg_s: float | None = physical("length_px", help="The same as a turn.", unit="deg/s", ge=0)
    gamma: float = setting(1.0, help="No unit.")


def geometry(photosite_um: float = 3.0, binning: float = 1.0) -> ImageGeometry:
    """An image of a lens of 4 mm."""
    return ImageGeometry(
        64,
        48,
        focal_length_px=4000 / (photosite_um * binning),
        centre_px=(31.5, 23.5),
        pixel_um=photosite_um * binning,
        camera="left",
        binning=binning,
    )


CONTEXT = ImageContext(exposure_s=0.01, black_level_dn=16.0, white_level_dn=255.0, dn_per_electron=0.25)


def test_settings_without_anything_physical_are_handed_on() -> None:
    config = Config(radius_px=2.0, sigma_dn=1.0, gamma=0.5)
    assert in_image_units(config, "effect.x", geometry(), CONTEXT) is config


def test_binning_shortens_lengths_averages_spreads_and_leaves_levels() -> None:
    config = Config(radius_px=2.0, sigma_dn=1.0, rows_dn=1.0, level_dn=200.0)
    image = in_image_units(config, "effect.x", geometry(binning=4), CONTEXT)
    assert (image.radius_px, image.sigma_dn, image.rows_dn, image.level_dn) == (0.5, 0.25, 0.5, 200.0)


def test_physical_values_come_to_those_of_the_image() -> None:
    config = Config(radius_um=6.0, sigma_e=8.0, level_e=400.0, speed_deg_s=100.0)
    image = in_image_units(config, "effect.x", geometry(binning=2), CONTEXT)
    assert image.radius_px == pytest.approx(1.0)  # 6 um are two photosites, one pixel of two by two
    assert image.sigma_dn == pytest.approx(1.0)  # 8 e- are 2 DN, half of it after averaging four
    assert image.level_dn == pytest.approx(116.0)  # 100 DN above the pedestal of 16
    assert image.length_px == pytest.approx(0.0174533 * 4000 / 6, rel=1e-5)  # a degree in 10 ms
    assert (image.radius_um, image.sigma_e, image.level_e, image.speed_deg_s) == (None, None, None, None)


def test_a_physical_value_and_that_of_the_image_exclude_each_other() -> None:
    with pytest.raises(ValidationError, match="radius_px and radius_um exclude each other: give one"):
        Config(radius_px=1.0, radius_um=3.0)


def test_charges_need_the_gain_of_the_camera() -> None:
    with pytest.raises(CandidateFailed, match=r"effect\.x has sigma_e = 8 e-, but .*'left' is not known"):
        in_image_units(Config(sigma_e=8.0), "effect.x", geometry(), ImageContext())


def test_what_is_out_of_bounds_on_this_camera_fails_the_candidate_with_the_value() -> None:
    with pytest.raises(CandidateFailed, match=r"effect\.x on camera 'left': radius_px comes to 1000"):
        in_image_units(Config(radius_um=3000.0), "effect.x", geometry(), CONTEXT)


def test_units_that_do_not_belong_together_are_a_defect_of_the_effect() -> None:
    with pytest.raises(ValueError, match="um does not stand for DN"):
        image_units_per("um", "DN", geometry=geometry(), context=CONTEXT)


@given(
    value=st.floats(0.01, 50),
    pitch=st.floats(1.0, 9.0),
    gain=st.floats(0.01, 10.0),
)
def test_to_physical_and_back_is_where_it_began(value: float, pitch: float, gain: float) -> None:
    context = ImageContext(exposure_s=0.02, black_level_dn=16.0, dn_per_electron=gain)
    given_dn = {"radius_px": value, "sigma_dn": value, "level_dn": 16.0 + value, "length_px": value}
    found = physical_settings_of(Config, given_dn, geometry(pitch), context)
    config = Config(**dict(found.values()))
    image = in_image_units(config, "effect.x", geometry(pitch), context)
    for name, before in given_dn.items():
        assert getattr(image, name) == pytest.approx(before, rel=1e-9)


def test_nothing_physical_is_said_where_the_gain_is_not_known() -> None:
    found = physical_settings_of(Config, {"sigma_dn": 1.0, "radius_px": 1.0}, geometry(), ImageContext())
    assert found == {"radius_px": ("radius_um", pytest.approx(3.0))}


def test_charges_in_digital_numbers_grow_with_the_gain():
    """Those found at 6 dB, at 26 dB: ten times as many; levels above the pedestal, lengths as they are."""
    at = ImageContext(gain_db=26.0, charges_at_db=6.0, dn_per_electron=2.0, black_level_dn=16.0)
    found = in_image_units(Config(sigma_dn=1.5, level_dn=20.0, radius_px=2.0), "effect.toy", geometry(), at)
    assert (found.sigma_dn, found.level_dn, found.radius_px) == (15.0, 56.0, 2.0)
    assert in_image_units(Config(sigma_e=3.0), "effect.toy", geometry(), at).sigma_dn == 6.0
