"""What a diagnosis of one camera says of others: physical units, and effects for any recipe."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import yaml

from tacos_framework.cli import run_main
from tacos_framework.formation import EpisodeDraws
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings, physical, setting
from tacos_gap.answer.findings import Cause, Parameter, Physical
from tacos_gap.answer.transfer import Photographed, of_specimen, patch, patched
from tacos_gap.captures import Noise
from tacos_gap.simulation.formation import simulate
from tests.gap.small_captures import BLACK_DN, bench, capture, placed, squares


class Lengths(Settings):
    """Settings of an effect with all there is."""

    radius_px: float = setting(0.0, help="Radius.", unit="px")
    radius_um: float | None = physical("radius_px", help="Radius.", unit="um")
    sigma_dn: float = setting(0.0, help="Spread.", unit="DN")
    sigma_e: float | None = physical("sigma_dn", help="Spread.", unit="e-")
    edge_dn: float = setting(0.0, help="A level nothing is known of elsewhere.", unit="DN")
    map: str | None = setting(None, help="Measured.", is_path=True)


def in_physical_units(name: str, value: float, camera: Photographed) -> Physical | None:
    fitted = Parameter(value, (0.9 * value, 1.1 * value), "")
    return camera.in_physical_units(Lengths, fitted, name).physical


def test_lengths_go_by_the_pitch_and_charges_by_the_conversion_gain():
    camera = Photographed.of(bench())  # 3 um, 0.24 DN of variance per DN: 0.24 DN an electron
    assert in_physical_units("radius_px", 1.5, camera) == Physical("radius_um", 4.5, (4.05, 4.95), "um")
    found = in_physical_units("sigma_dn", 1.2, camera)
    assert found is not None
    assert (found.name, found.unit) == ("sigma_e", "e-")
    assert found.value == pytest.approx(5.0)
    assert found.interval == pytest.approx((4.5, 5.5))
    assert in_physical_units("edge_dn", 3.0, camera) is None


def test_without_a_conversion_gain_there_are_no_electrons():
    darks = [replace(each, noise=Noise((0.0,), (2.0,))) for each in bench()]
    camera = Photographed.of(darks)
    assert in_physical_units("sigma_dn", 1.2, camera) is None
    assert in_physical_units("radius_px", 1.5, camera) is not None


def test_the_gain_most_captures_were_taken_at_counts():
    at = [
        replace(
            capture(f"flat_{db}_{i}", "flat", BLACK_DN + 50),
            noise=Noise((k,), (1.0,)),
        )
        for db, k, count in ((0, 0.1, 1), (6, 0.2, 3))
        for i in range(count)
    ]
    at = [replace(c, context=replace(c.context, gain_db=float(c.id.split("_")[1]))) for c in at]
    camera = Photographed.of(at)
    assert camera.context.dn_per_electron == pytest.approx(0.2)
    assert str(camera) == "a camera with pixels of 3 um at 6 dB, files up to 255 DN"


# patched.yaml ---------------------------------------------------------------------------------------------


def cause(effect: str, settings: dict[str, Any], parameters: dict[str, Parameter], **changes: Any) -> Cause:
    made = Cause(effect, 0.9, parameters, 0.9, (0.8, 1.0), "", 0.9, (), "", settings)
    return replace(made, **changes)


def test_a_patch_is_physical_and_says_what_is_not():
    camera = Photographed.of(bench())
    found = cause(
        "toy",
        {"radius_px": 1.5, "edge_dn": 3.0, "map": "map.npy", "k1": -0.2},
        {
            "radius_px": Parameter(1.5, (1.4, 1.6), "px", Physical("radius_um", 4.5, (4.2, 4.8), "um")),
            "edge_dn": Parameter(3.0, (2.9, 3.1), "DN"),
            "map": Parameter("map.npy", None, "1"),
            "k1": Parameter(-0.2, (-0.3, -0.1), "1"),
        },
        specimen=("map",),
    )
    assert patch([found]) == [{"use": "effect.toy", "radius_um": 4.5, "edge_dn": 3.0, "k1": -0.2}]
    text = patched([found], camera)
    assert yaml.safe_load(text) == patch([found])
    assert "# Left out. effect.toy, map: measured on one specimen, which no other camera has." in text
    assert "# edge_dn: as of a camera with pixels of 3 um at 0 dB, files up to 255 DN" in text
    assert "radius" not in "".join(line for line in text.splitlines() if line.startswith("#"))
    assert yaml.safe_load(patched([], camera)) == []


@pytest.mark.parametrize(("present", "is_said"), [(0.97, False), (0.02, True)])
def test_a_patch_says_what_fits_and_is_not_proven(present, is_said):
    found = cause("toy", {"k1": -0.2}, {"k1": Parameter(-0.2, (-0.3, -0.1), "1")}, present=present)
    text = patched([found], Photographed.of(bench()))
    assert yaml.safe_load(text) == patch([found])
    assert ("# Fits, but is not proven: 2%" in text) == is_said


def test_what_names_a_file_belongs_to_one_specimen():
    prnu = Plugins.discover().resolve("effect.prnu").Config
    assert of_specimen(Lengths, "map")
    assert of_specimen(prnu, "map")
    assert not of_specimen(prnu, "sigma")


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("defocus", {"radius_px": 1.5}),
        ("lens-blur", {"sigma_px": 1.1}),
        ("read-noise", {"sigma_dn": 1.5}),
        ("read-noise", {"sigma_dn": 1.0, "after_gain_dn": 1.2}),
        ("row-noise", {"sigma_dn": 1.5, "column_sigma_dn": 0.5}),
        ("dark-current", {"rate_dn_s": 20.0}),
        ("black-level", {"offset_dn": 2.0}),
        ("saturation", {"level_dn": 180.0}),
        ("motion-blur", {"length_px": 6.0}),
    ],
)
def test_physical_settings_simulate_the_captured_camera_as_those_in_pixels_do(name, settings, tmp_path):
    cls = Plugins.discover().resolve(f"effect.{name}")
    captures = [capture("edges", "edge", squares()), capture("dark", "dark", BLACK_DN)]
    camera = Photographed.of(captures)
    parameters = {
        key: camera.in_physical_units(cls.Config, Parameter(value, None, ""), key)
        for key, value in settings.items()
    }
    (added,) = patch([cause(name, settings, parameters)])
    assert set(added) & set(settings) == set(), "all of them transfer"
    own, other = (
        placed(name, cls, **settings),
        placed(name, cls, **{k: v for k, v in added.items() if k != "use"}),
    )
    for each in captures:
        frames = [simulate(each, [effect], EpisodeDraws(1, ("a",))) for effect in (own, other)]
        difference = np.abs(frames[0] - frames[1])
        assert difference.max() <= 1, "of rounding alone"
        assert difference.mean() < 0.03
    path = tmp_path / "patched.yaml"
    path.write_text(patched([cause(name, settings, parameters)], camera))
    assert run_main(["headset_quick", "--with", str(path), "--check"]) == 0
