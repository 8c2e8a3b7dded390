"""Scores of each camera in each scenario."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_report.page import Block, Detailed, Paragraph, Table
from tacos_report.quantities import number, words
from tacos_report.study_data import CameraResult, StudyData


def blocks(study: StudyData) -> Iterator[Block]:
    cameras = [camera for camera in study.cameras if camera.scenarios]
    names = list(dict.fromkeys(name for camera in cameras for name in camera.scenarios))
    if len(names) < 2:
        return
    yield Paragraph("Fitness on unseen scenes by scenario, with the scores it is made of.")
    yield Table(
        ("Scenario", *(camera.title for camera in cameras), "Best"),
        tuple((name, *(_cell(camera, name) for camera in cameras), _best(cameras, name)) for name in names),
    )


def _cell(camera: CameraResult, scenario: str) -> str | Detailed:
    scores = camera.scenarios.get(scenario, {})
    if "fitness" not in scores:
        return ""
    others = (f"{words(name)} {number(value)}" for name, value in scores.items() if name != "fitness")
    return Detailed(number(scores["fitness"]), "; ".join(others))


def _best(cameras: list[CameraResult], scenario: str) -> str:
    scored = {
        c.title: c.scenarios[scenario]["fitness"]
        for c in cameras
        if "fitness" in c.scenarios.get(scenario, {})
    }
    return max(scored, key=lambda title: scored[title], default="")
