"""The sections that answer: everything that is known is told, and whatever is missing leaves no trace."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tacos_report import write_report
from tacos_report.analysis import Analysis, read_analysis
from tacos_report.figures.carriers import carrier_of
from tacos_report.figures.side_view import side_view
from tacos_report.page import html_of
from tacos_report.pictures import MOST_ENLARGED, EmbeddedImage, FramePlacement, row_width_px
from tacos_report.sections import ranking
from tacos_report.study_data import CameraResult, StudyData, read_study
from tacos_report.study_page import study_page
from tests.report.analysed_results import analysed, decided
from tests.report.results_folder import write_json, write_results
from tests.report.test_study_page import Page

MEASURED = """<iframe id=f src="REPORT" style="border:0;width:390px;height:9000px"></iframe><script>
onload = () => {
  const page = f.contentDocument, cut = [];
  const right = e => e.getBoundingClientRect().right;
  for (const e of page.querySelectorAll('main *, header *'))
    if (!e.closest('.table, .drawing, svg, pre') && right(e) > 390.5) cut.push(e.tagName);
  for (const e of page.querySelectorAll('.table, .drawing')) if (right(e) > 390.5) cut.push(e.className);
  const scrolled = [...page.querySelectorAll('.drawing:not(:has(.frames))')]
    .filter(e => e.scrollWidth > e.clientWidth + 1).map(e => e.querySelector('svg').ariaLabel);
  const width = page.documentElement.scrollWidth;
  document.body.innerHTML = `width=${width} cut=[${cut}] scrolled=[${scrolled}]`;
}</script>"""
"""A page that measures a report as wide as a phone; tables and rows of frames scroll, drawings do not."""

LENS = {"name": "DSL219", "mount": "M12", "focal_length_mm": 2.2, "image_circle_mm": 8.2, "price_usd": None}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results folder with every key there is."""
    folder = write_results(tmp_path_factory.mktemp("analysed"), moments=1)
    result = json.loads((folder / "result.json").read_text("utf-8"))
    result.update(decided(result), **analysed(result), carrier="person")
    designed = result["cameras"]["designed"]
    del designed["camera"]["focal_length_mm"]
    designed["camera"]["lens"] = LENS
    designed["derived"].update(image_circle_margin_mm=0.4, mount_fits=0.0)
    result["notes"].append("Not published: the distortion of DSL219.")
    result["environment"]["findings"] = {"OpenGL": "llvmpipe"}
    for place, camera in enumerate(result["cameras"].values()):
        camera["scenarios"] = {"day": {"fitness": 1.4 - place}, "night": {"fitness": 0.5 + place}}
    write_json(folder, result)
    return folder


@pytest.fixture(scope="module")
def page(folder: Path) -> Page:
    return Page(write_report(folder).read_text("utf-8"))


@pytest.mark.parametrize(
    "said",
    [
        "better than the Luxonis OAK-D Pro Wide, the best of 3",
        "+0.055 (between +0.031 and +0.079)",
        "fisheye 190 hfov_deg is 152, above its maximum of 140",
        "Lens DSL219",
        "Image circle of the lens covers the sensor: 0.4 mm to spare",
        "Mount of the lens does not fit",
        "Not published price",
        "Before you order Not published: the distortion of DSL219.",
        "P(better than FLIR Flea3)",
        "LINE4K megapixels is 31.2",
        "not stated: power",
        "5 of 43 parts lie within a margin of 0.012 of the best",
        "The scenes do not rule out 2 more; in brackets, the probability that they are as good",
        "(21 %)",
        "1.9 mm to 4.4 mm",
        "Pixel count (less is better)",
        "Scenario by scenario",
        "43 choices, searched by their properties, then the nearest part",
        "OpenGL llvmpipe",
    ],
)
def test_the_page_tells(said: str, page: Page) -> None:
    assert said in page.text


def test_parts_left_out_for_one_reason_share_a_row() -> None:
    why = {"A": "ruled out by the constraint on sensor.shutter", "B": "too large"}
    analysis = Analysis(left_out={**why, "C": why["A"]})
    (table,) = ranking.blocks(StudyData({}, (), (), analysis=analysis))
    assert table.rows == (("A, C", why["A"]), ("B", "too large"))


def test_a_note_on_a_part_to_buy_stands_with_that_part_alone(page: Page) -> None:
    assert page.text.count("Not published: the distortion of DSL219.") == 1
    assert page.text.count("Before you rely on this") == 1


def test_the_answers_are_drawn_for_phones_as_well(page: Page) -> None:
    said = [attrs["aria-label"] or "" for tag, attrs in page.tags if tag == "svg"]
    for opening in ("Designed camera against products: ", "43 parts by fitness", "Tolerances: ",
                    "Importance: ", "Fitness along: ", "5 cameras of a front", "Fitness on unseen scenes by ",
                    "Search curve: ", "Fitness of 113 candidates", "Best fitness by sensor"):  # fmt: skip
        assert sum(each.startswith(opening) for each in said) == 2


def test_each_finding_has_its_picture(page: Page) -> None:
    said = " ".join(attrs["aria-label"] or "" for tag, attrs in page.tags if tag == "svg")
    for opening in ("against products: ", "43 parts by fitness", "Tolerances: ", "Importance: ",
                    "Fitness along: ", "cameras of a front"):  # fmt: skip
        assert opening in said


def test_results_of_before_have_none_of_it(tmp_path: Path) -> None:
    text = Page(write_report(write_results(tmp_path, moments=1)).read_text("utf-8")).text
    for title in ("How sure is that?", "All parts, ranked", "Any of these will do", "What matters", "aim"):
        assert title not in text
    assert "Lens to be found Focal length 2.36" in text


# whatever stands in the keys ------------------------------------------------------------------------------

ODD = st.sampled_from(
    [None, {}, [], "", "odd", float("nan"), float("inf"), -1, 0, 0.5, True, [1], {"a": {"b": None}}]
)
KEYS = ("decision", "comparisons", "ranking", "ranking_left_out", "equivalent", "importance", "front")


def spoilt(value: Any, draw: st.DrawFn) -> Any:
    """The value with some of what it holds replaced by something odd."""
    if draw(st.integers(0, 11)) == 0:
        return draw(ODD)
    if isinstance(value, dict):
        return {name: spoilt(each, draw) for name, each in value.items()}
    return [spoilt(each, draw) for each in value] if isinstance(value, list) else value


@st.composite
def odd_results(draw: st.DrawFn, result: dict[str, Any]) -> dict[str, Any]:
    """A result whose analysis is spoilt here and there; a short ranking, since each part costs time."""
    whole = {**{key: result[key] for key in KEYS}, "ranking": result["ranking"][:4]}
    degenerate = draw(st.sampled_from([None, "", {}, "All scores are equal."]))
    return {**result, **{key: spoilt(whole[key], draw) for key in KEYS}, "degenerate": degenerate}


UNSHRUNK = (Phase.explicit, Phase.generate)  # a page takes half a second: shrinking would take minutes


@settings(
    max_examples=12, deadline=None, derandomize=True, phases=UNSHRUNK, suppress_health_check=[*HealthCheck]
)
@given(data=st.data())
def test_odd_values_never_reach_the_reader(folder: Path, data: st.DataObject) -> None:
    study = read_study(folder)
    result = data.draw(odd_results(dict(study.result)))
    cameras = tuple(replace(camera, samples=(), derived={}) for camera in study.cameras)
    odd = replace(study, result=result, analysis=read_analysis(result), cameras=cameras, generations=())
    text = Page(html_of(study_page(replace(odd, log="", recipe="")))).text
    assert re.findall(r".{60}(?:\bNone\b|\bnan\b|\binf\b|not a number|\{'|\[\])", text) == []


# how it looks ---------------------------------------------------------------------------------------------


@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_nothing_is_cut_off_on_a_phone(folder: Path, page: Page, tmp_path: Path) -> None:
    outer = tmp_path / "phone.html"
    outer.write_text(MEASURED.replace("REPORT", (folder / "report.html").as_uri()), "utf-8")
    options = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--virtual-time-budget=5000",
    ]
    options += ["--allow-file-access-from-files", f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom"]
    command = ["chromium", *options, outer.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert "width=390 cut=[] scrolled=[]" in done.stdout


def test_a_car_is_drawn_as_a_car_and_nobody_is_guessed() -> None:
    cameras = [CameraResult("designed", "Designed camera", {}, {"vfov_deg": 40.0})]
    person, car, unknown = (side_view(cameras, 2.0, carrier) for carrier in ("person", "car", ""))
    assert len({person, car, unknown}) == 3
    assert "eye at" in person
    assert "camera at" in car
    assert carrier_of("submarine") is carrier_of("")
    assert "15 m" in car, "the ground that a car's camera sees begins metres ahead"


def test_small_frames_stay_small() -> None:
    one = row_width_px([EmbeddedImage("", 364, 200)], [FramePlacement(100.0, 0.0)])
    assert one == round(364 * MOST_ENLARGED)
    two = row_width_px(
        [EmbeddedImage("", 100, 50), EmbeddedImage("", 400, 50)],
        [FramePlacement(50.0, 0), FramePlacement(50.0, 0)],
    )
    assert two == round(200 * MOST_ENLARGED), "the smallest decides, as all are drawn to one scale"
