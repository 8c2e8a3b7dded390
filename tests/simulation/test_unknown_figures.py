"""What is not known of a part scatters its scores from scene to scene, and so widens its intervals."""

from __future__ import annotations

import math

import numpy as np

from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.simulation import EpisodeSpec, Simulation
from tacos_framework.study.sequential import confidence_interval
from tests.toy_study import toy_recipe

PITCH_UM = 3.0
KNOWN = {
    "quantum_efficiency": 0.6,
    "full_well_e": 10_000.0,
    "read_noise_e": 2.0,
    "dark_current_e_s": 5.0,
    "red_over_green": 0.5,
    "blue_over_green": 0.7,
}
PART = {"width_px": 16, "height_px": 8, "pixel_um": PITCH_UM}
SCENES = 40


def brightness(plugins: Plugins, part: dict[str, object], tests: int = 1001) -> np.ndarray:
    """(SCENES,) score of a part on test scenes."""
    recipe = toy_recipe(
        rig={"use": "rig.monocular", "sensor": part},
        nodes={
            "frames": {"use": "sensor.camera", "in": {"capture": "capture"}, "black_level_dn": 0},
            "world": {"use": "scene.toy", "frames": 1},
        },
        scenario={"illumination_lux": 100, "exposure_ms": 10},
    )
    simulation = Simulation(make_plan(recipe, plugins))
    camera = {"focal_length_mm": 1.0, "pitch_deg": 0.0}
    scored = simulation.evaluate(
        camera,
        [EpisodeSpec(tests, ("test", i), 1) for i in range(SCENES)],
        states={},
        training=None,
        partial=False,
    )
    assert scored.failed is None
    return np.array([episode["width.brightness"] for episode in scored.episodes])


def width(scores: np.ndarray) -> float:
    found = confidence_interval(scores, 0.05)
    assert found is not None
    return found[1] - found[0]


def test_of_two_equal_parts_the_one_with_unknown_figures_is_less_certain(toys: Plugins) -> None:
    """The full well is unknown by a factor of 1.55, and the image as bright as one over it."""
    reference = brightness(toys, {**PART, "name": "reference", **KNOWN})
    known = brightness(toys, {**PART, "name": "part", **KNOWN})
    lacking = {name: value for name, value in KNOWN.items() if name != "full_well_e"}
    unknown = brightness(toys, {**PART, "name": "part", **lacking})
    ratio = np.log(unknown / known)
    assert width(np.log(known / reference)) < 0.01
    assert math.isclose(np.std(ratio, ddof=1), 0.44, rel_tol=0.3)
    assert width(np.log(unknown / reference)) > 20 * width(np.log(known / reference))


def test_candidates_with_the_same_part_share_what_is_drawn(toys: Plugins) -> None:
    first, again = (brightness(toys, {**PART, "name": "part"}) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    other = brightness(toys, {**PART, "name": "another"})
    assert np.abs(np.log(other / first)).min() > 1e-4
