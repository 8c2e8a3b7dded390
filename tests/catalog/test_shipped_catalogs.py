"""The catalogs that come with the package say what the paper says, and no more than anyone has said."""

from __future__ import annotations

import csv
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tacos_framework.catalog import CatalogPart, camera_names, catalog_names, find_catalog, load_cameras
from tacos_framework.variables.design_space import CatalogChoice, DesignSpace
from tacos_plugins.sensors.calibration import load_calibration

SENSORS = [part for name in ("image_sensors", "image_sensors_more") for part in find_catalog(name).rows]


def test_the_catalog_is_the_paper_s() -> None:
    # supplement, "Image Sensor Catalog"
    catalog = find_catalog("image_sensors")
    assert Counter(part["maker"] for part in catalog.rows) == {
        "Sony": 28,
        "onsemi": 10,
        "Luxima": 3,
        "CMOSIS (ams)": 2,
    }
    pitches = [part.number("pixel_um") for part in catalog.rows]
    assert (min(pitches), max(pitches)) == (1.12, 9.0)
    by_area = sorted(catalog.rows, key=lambda part: part.number("width_mm") * part.number("height_mm"))
    assert [round(by_area[0].number(column), 2) for column in ("width_mm", "height_mm")] == [3.07, 2.30]
    assert [round(by_area[-1].number(column), 2) for column in ("width_mm", "height_mm")] == [16.13, 12.04]


@pytest.mark.parametrize(
    ("name", "column", "value"),
    [
        ("IMX172", "width_mm", 6.2),
        ("LUX1310", "width_mm", 8.448),  # paper, Table 2: 8.45 x 6.76 mm, 6.6 um
        ("LUX1310", "pixel_um", 6.6),
        ("IMX432", "height_mm", 9.936),  # paper, Table 2: 14.48 x 9.94 mm, 9 um
        ("IMX335", "shutter", "rolling"),
        ("IMX273", "full_well_e", 11000.0),
        ("IMX273", "read_noise_e", 2.1),
        ("IMX273", "mounts", "C, CS, M12"),
        ("IMX273", "power_w", 2.4),
        ("IMX287", "full_well_e", 20800.0),  # the data sheet's misprint is ten times that
        ("IMX172", "power_w", None),
        ("PYTHON300", "quantum_efficiency", None),
    ],
)
def test_values_of_known_parts(name: str, column: str, value: object) -> None:
    assert find_catalog("image_sensors").part(name)[column] == value


@pytest.mark.parametrize("name", catalog_names())
def test_every_known_value_has_a_source_and_unknown_ones_have_none(name: str) -> None:
    for part in find_catalog(name).rows:
        known = {column for column, value in part.values.items() if value is not None}
        assert set(part.provenance) == known
        assert all(part.provenance.values())


@pytest.mark.parametrize("name", ["image_sensors", "lenses", "lenses_fisheye"])
def test_every_stated_value_is_graded(name: str) -> None:
    for part in find_catalog(name).rows:
        computed = {c for c, source in part.provenance.items() if source.endswith("_px x pixel_um")}
        assert set(part.grades) == set(part.provenance) - computed


def test_the_camera_columns_are_of_one_camera() -> None:
    for name in ("image_sensors", "image_sensors_more"):
        for part in find_catalog(name).rows:
            known = [
                c for c in ("frame_rate_fps", "power_w", "camera_mass_g", "mounts") if part[c] is not None
            ]
            assert bool(known) <= (part["camera"] is not None), part.name


SHARED = Path(__file__).parents[3] / "shared" / "data"
needs_shared = pytest.mark.skipif(
    not SHARED.is_dir(), reason="the folder of public data is not beside the checkout"
)


@needs_shared
def test_line_times_and_gains_are_those_of_the_collected_sources() -> None:
    with (SHARED / "catalogs" / "robotics_sensors.csv").open(newline="") as file:
        stated = {row["name"]: row for row in csv.DictReader(file)}
    assert len(stated) == 55
    same = {"row_time_us": "row_time_us", "max_fps": "max_fps_full", "gain_max_db": "gain_max_db"}
    for name, row in stated.items():
        part = next(part for part in SENSORS if part.name == name)
        for column, given in same.items():
            value = float(row[given]) if row[given] else None
            assert part[column] == value, (name, column)


@needs_shared
@pytest.mark.parametrize(
    ("column", "value_name", "scale"),
    [
        ("full_well_e", "saturation_capacity", 1.0),
        ("read_noise_e", "temporal_dark_noise", 1.0),
        ("quantum_efficiency", "quantum_efficiency", 0.01),
        ("frame_rate_fps", "max_frame_rate", 1.0),
        ("power_w", "power", 1.0),
    ],
)
def test_values_are_those_of_the_collected_sources(column: str, value_name: str, scale: float) -> None:
    with (SHARED / "sensor_characteristics.csv").open(newline="") as file:
        stated = [row for row in csv.DictReader(file) if row["value_name"] == value_name]
    checked = 0
    for part in find_catalog("image_sensors").rows:
        values = [float(r["value"]) * scale for r in stated if r["sensor"] == part.name]
        if part.grades.get(column) == "transcription":
            assert any(part.number(column) == pytest.approx(value) for value in values), part.name
            checked += 1
    assert checked >= 5


def test_lenses_can_be_bought_and_no_fisheye_is_among_them() -> None:
    lenses, fisheyes = find_catalog("lenses"), find_catalog("lenses_fisheye")
    assert (len(lenses.rows), len(fisheyes.rows)) == (71, 26)
    assert {part["mount"] for part in lenses.rows} == {"M12", "M8", "CS", "C", None}
    names = {part.name for part in lenses.rows}
    assert names.isdisjoint(part.name for part in fisheyes.rows)
    assert not any("isheye" in name or "GoPro" in name for name in names)


def test_an_image_circle_that_follows_from_a_format_is_derived() -> None:
    lenses = find_catalog("lenses")
    tiny = lenses.part("OpenMV IR Lens 2.8 mm")
    assert (tiny["image_circle_mm"], tiny.grades["image_circle_mm"]) == (6.0, "derived")
    stated = lenses.part("Allied Vision C-8-F2.4-10MP-T2-3")
    assert (stated["image_circle_mm"], stated.grades["image_circle_mm"]) == (11.0, "transcription")
    assert lenses.part("Tamron M118FM06")["image_circle_mm"] is None


def test_only_a_dated_price_is_given() -> None:
    priced = [part for part in find_catalog("lenses").rows if part["price_eur"] is not None]
    assert [part.name for part in priced] == ["Tamron M118FM08"]
    assert "February 2025" in priced[0].provenance["price_eur"]


def test_no_sensor_stands_in_two_catalogs() -> None:
    names = [part.name for part in SENSORS]
    assert len(names) == len(set(names)) == 108


def test_words_of_sensors_are_those_that_rigs_take() -> None:
    filters = {"none", "Bayer", "quad Bayer", "RGGB", "BGGR", "GRBG", "GBRG", None}
    for part in SENSORS:
        assert part["shutter"] in ("global", "rolling", None), part.name
        assert part["colour"] in ("mono", "colour", None), part.name
        assert part["cfa"] in filters, part.name
        assert part["cfa"] != "none" or part["colour"] == "mono", part.name


@pytest.mark.parametrize(
    "part", [part for part in SENSORS if part["frame_lines"]], ids=lambda part: part.name
)
def test_frames_of_drivers_take_as_long_as_their_rows(part: CatalogPart) -> None:
    """Line time, lines with blanking and frame rate are three statements of one driver, or it has said so."""
    computed = 1e6 / (part.number("row_time_us") * part.number("frame_lines"))
    assert part["frame_lines"] >= part["height_px"]
    agrees = part.number("max_fps") == pytest.approx(computed, rel=0.01)
    assert agrees or any("default" in doubt for doubt in part.doubts)


def test_noise_values_name_their_own_source() -> None:
    catalog = find_catalog("image_sensors")
    for part in catalog.rows:
        for column in ("full_well_e", "read_noise_e", "bit_depth"):
            assert part.provenance.get(column) != catalog.source


def test_rows_the_original_catalog_has_wrong_are_doubted() -> None:
    doubted = {part.name for part in find_catalog("image_sensors").rows if part.doubts}
    assert {"MT9V022", "IMX335", "PYTHON500", "PYTHON2000"} <= doubted
    assert "IMX172" not in doubted


def test_further_sensors_keep_their_unknowns() -> None:
    catalog = find_catalog("image_sensors_more")
    assert len(catalog.rows) == 65
    choice = CatalogChoice("sensor", catalog, "discrete")
    assert {"OV2311", "IMX585", "VD56G3"} < {part.name for part in choice.left_out}
    assert len(choice.rows) + len(choice.left_out) == 65
    with pytest.raises(ValueError, match=r"AR0144 and OV9281 are equal in .* use scheme discrete"):
        CatalogChoice("sensor", catalog, "quantized")


@pytest.mark.parametrize("scheme", ["quantized", "discrete"])
@pytest.mark.parametrize("distance", ["normalised", "plain"])
def test_every_sensor_of_the_paper_can_be_designed_with(scheme: str, distance: str) -> None:
    catalog = find_catalog("image_sensors")
    space = DesignSpace([CatalogChoice("sensor", catalog, scheme, None, distance)])  # type: ignore[arg-type]
    for part in catalog.rows:
        assert space.decode(space.encode({"sensor": part})).values["sensor"] == part
    rng = np.random.default_rng(0)
    drawn = {space.sample(rng).values["sensor"].name for _ in range(1500)}
    assert len(drawn) > (42 if scheme == "discrete" else 30)


def test_the_cameras_of_the_paper() -> None:
    cameras = {camera.name: camera for camera in load_cameras(camera_names())}
    assert cameras["basler_dart"].fixes["focal_length_mm"] == 3.6
    assert "3.04" in cameras["basler_dart"].notes[0]
    assert cameras["zed_2i"].fixes == {"baseline_m": 0.12, "hfov_deg": 72}
    assert cameras["realsense_d450"].fixes == {"baseline_m": 0.095, "hfov_deg": 87}
    sizes = {
        name: tuple(
            round(cameras[name].fixes["sensor"][f"{side}_px"] * 1e-3 * pitch, 2)
            for side in ("width", "height")
        )
        for name, pitch in (("oak_d_pro_wide", 1.55), ("flea3", 1.55), ("basler_dart", 3.75))
    }
    assert sizes == {"oak_d_pro_wide": (6.29, 4.71), "flea3": (6.2, 4.65), "basler_dart": (4.8, 3.6)}


@pytest.mark.parametrize("name", ["oak_d_pro_wide", "flea3", "basler_dart"])
def test_sensors_of_cameras_are_those_of_the_catalogs(name: str) -> None:
    [camera] = load_cameras([name])
    sensor = camera.fixes["sensor"]
    parts = {part.name: part for catalog in catalog_names() for part in find_catalog(catalog).rows}
    part = parts[sensor["name"]]
    assert {column: part[column] for column in sensor if column != "name"} == {
        column: value for column, value in sensor.items() if column != "name"
    }


def test_the_noise_calibration_is_of_variances() -> None:
    calibration = load_calibration("flea3_imx172")
    assert calibration.photon_dn == (0.24, 0.12, 0.29)
    assert calibration.thermal_dn2 == (1.82, 0.91, 3.2)
    # Green at 128 DN and 5 dB has 35.2 dB, which only holds for variances.
    ratio = 10 ** ((5 - calibration.gain_db) / 20)
    variance = ratio * calibration.photon_dn[1] * 128 + ratio**2 * calibration.thermal_dn2[1]
    assert 20 * math.log10(128 / math.sqrt(variance)) == pytest.approx(35.2, abs=0.05)


def test_the_responsivity_is_what_its_note_says() -> None:
    calibration = load_calibration("flea3_imx172")
    luminance_cd_m2 = 0.8 * 20 / math.pi
    exposure_lux_s = math.pi * luminance_cd_m2 * 0.030 / (4 * 2.0**2)
    signal_dn = calibration.responsivity_dn_per_lux_s * 10 ** ((5 - 15) / 20) * exposure_lux_s
    assert signal_dn == pytest.approx(200, abs=0.01)
