"""Results say where the noise of their cameras comes from."""

from __future__ import annotations

from toy_study import FROM_CATALOG

from tacos_framework.plan import make_plan
from tacos_framework.plan.origins import notes_on_noise
from tacos_framework.recipe import Recipe
from tacos_framework.variables.design_space import CatalogChoice


def cameras_of(plan, *sensors):
    (choice,) = (v for v in plan.space.variables if isinstance(v, CatalogChoice))
    corner = plan.space.decode([gene.lower for gene in plan.space.genes]).as_dict()
    return [{**corner, choice.name: choice.catalog.part(sensor).as_dict()} for sensor in sensors]


def test_sensors_with_the_same_origins_share_a_sentence(toys, monkeypatch):
    plan = make_plan(Recipe.model_validate(FROM_CATALOG), toys)
    (sensor,) = (part for part in plan.nodes.values() if part.use.startswith("sensor."))

    def origins(self, camera):
        return {"full_well_e": "catalog" if camera.electrons.sensor == "IMX273" else "assumed"}

    monkeypatch.setattr(sensor.cls, "origins", origins, raising=False)
    assert list(notes_on_noise(plan, cameras_of(plan, "IMX136", "IMX273", "IMX252"))) == [
        "Noise simulated for IMX136, IMX252: full well [e-] assumed.",
        "Noise simulated for IMX273: full well [e-] as the catalog states.",
    ]


def test_a_sensor_that_fails_to_say_costs_a_note_alone(toys, monkeypatch):
    plan = make_plan(Recipe.model_validate(FROM_CATALOG), toys)
    (sensor,) = (part for part in plan.nodes.values() if part.use.startswith("sensor."))

    def origins(self, camera):
        raise KeyError("full_well_e")

    monkeypatch.setattr(sensor.cls, "origins", origins, raising=False)
    (note,) = notes_on_noise(plan, cameras_of(plan, "IMX136"))
    assert "fails to say them: 'full_well_e'" in note
