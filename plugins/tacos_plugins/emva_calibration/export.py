"""The figures as settings of the electron sensor, in YAML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tacos_framework import to_yaml
from tacos_plugins.emva_calibration.data_sheet import DataSheet

_HEADING = "# Settings of the electron sensor, by EMVA 1288: `sensor:` of a recipe, or a node of its graph.\n"


def sensor_settings(sheets: Sequence[DataSheet]) -> tuple[dict[str, object], tuple[str, ...]]:
    """Settings of `sensor.emva` that were measured, and those that were not, each with the reason."""
    sheet = sheets[0]
    names = {
        "quantum_efficiency": "quantum_efficiency",
        "full_well_e": "saturation_capacity_e",
        "read_noise_e": "dark_noise_e",
        "dark_current_e_s": "dark_current_e_s",
        "system_gain_dn_per_e": "system_gain_dn_per_e",
        "black_level_dn": "black_level_dn",
    }
    settings: dict[str, object] = {"use": "sensor.emva"}
    missing = []
    for setting, name in names.items():
        value = sheet.value(name)
        if value is None:
            missing.append(f"{setting}: {sheet.figures[name].reason}")
        elif name == "quantum_efficiency" and value > 1:
            missing.append(f"{setting}: {value:.3g} is above 1, which no camera reaches")
        else:
            settings[setting] = float(f"{max(value, 0.0):.6g}")
    settings["bit_depth"] = sheet.channel.bit_depth
    if len(sheets) == 1:
        settings["channels"] = "mono"
    else:
        efficiency = {each.channel.name: each.value("quantum_efficiency") for each in sheets}
        green = efficiency["G"]
        if green is not None and all(value is not None for value in efficiency.values()):
            settings["channel_response"] = [round((efficiency[c] or 0.0) / green, 4) for c in "RGB"]
    return settings, tuple(missing)


def sensor_yaml(settings: Mapping[str, object], missing: Sequence[str]) -> str:
    return _HEADING + to_yaml(dict(settings)) + "".join(f"# not measured: {text}\n" for text in missing)
