"""A report in a browser: contrast, keyboard, and a part that opens what is known of it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tacos_report import palette, write_report
from tests.report.analysed_results import analysed, decided
from tests.report.results_folder import write_json, write_results

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
LEAST_TEXT, LEAST_LARGE = 4.5, 3.0
"""Contrast of text, and of large text and marks (WCAG 2.2, criteria 1.4.3 and 1.4.11, level AA)."""

STEPS = """
const parse = (css) => (css.match(/[\\d.]+/g) || []).map(Number);
const luminance = (rgb) => rgb.slice(0, 3).map((v) => v / 255)
  .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
  .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
const ratio = (a, b) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
const behind = (e) => {
  for (; e; e = e.parentElement) {
    const colour = parse(getComputedStyle(e).backgroundColor);
    if (colour.length < 4 || colour[3] > 0) return luminance(colour);
  }
};
const said = { faint: [], unringed: [] };
const details = [...document.querySelectorAll("details")];
said.closed = details.every((e) => !e.open);
details.forEach((e) => (e.open = true));
for (const e of document.querySelectorAll("body *")) {
  if (e.closest("svg, script") || ![...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim())) continue;
  const style = getComputedStyle(e);
  const size = parseFloat(style.fontSize);
  const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
  const found = ratio(luminance(parse(style.color)), behind(e));
  const words = e.textContent.trim().slice(0, 30);
  if (found < (large ? LARGE : TEXT)) said.faint.push(`${e.tagName} ${found.toFixed(2)} ${words}`);
}
const reached = [...document.querySelectorAll("a, button, input, summary, .table")];
said.reached = reached.every((e) => e.tabIndex >= 0 || e.tagName === "SUMMARY");
for (const e of reached) {
  if (!e.offsetParent) continue;
  e.focus({ focusVisible: true });
  const style = getComputedStyle(e);
  const ringed = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
  if (document.activeElement !== e || !ringed) said.unringed.push(e.outerHTML.slice(0, 60));
}
details.forEach((e) => (e.open = false));
const link = [...document.querySelectorAll('.table a[href^="#part-"]')].find((e) => e.textContent === "PART");
link.click();
const part = document.querySelector(link.hash);
said.opened = Boolean(part.closest("details").open && part.offsetParent);
said.others = details.filter((e) => e.open).length;
said.text = part.textContent.replace(/\\s+/g, " ");
said.frames = [...part.querySelectorAll("img")].filter((e) => e.src.startsWith("data:")).map((e) => e.alt);
document.title = JSON.stringify(said);
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = write_results(tmp_path_factory.mktemp("access"), moments=1)
    result = json.loads((folder / "result.json").read_text("utf-8"))
    result.update(decided(result), **analysed(result))
    write_json(folder, result)
    write_report(folder)
    return folder


@pytest.fixture(scope="module", params=["light", "dark"])
def said(
    request: pytest.FixtureRequest, folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """What the page is like in either mode of the reader's program."""
    html = (folder / "report.html").read_text("utf-8")
    tmp_path = tmp_path_factory.mktemp(request.param)
    dark = "@media screen and (prefers-color-scheme: dark)"
    assert dark in html
    html = html.replace(dark, "@media screen" if request.param == "dark" else "@media not all")
    designed = json.loads((folder / "result.json").read_text("utf-8"))["best"]["camera"]["sensor"]["name"]
    steps = (
        STEPS.replace("LARGE", str(LEAST_LARGE)).replace("TEXT", str(LEAST_TEXT)).replace("PART", designed)
    )
    driven = re.sub(r"<meta http-equiv.*?>", "", html).replace("</body>", f"<script>{steps}</script></body>")
    (tmp_path / "page.html").write_text(driven, "utf-8")
    command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000"]
    done = subprocess.run(
        [*command, f"--user-data-dir={tmp_path}/browser", "--dump-dom", f"file://{tmp_path}/page.html"],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    title = re.search(r"<title>(\{.*?)</title>", done.stdout, re.DOTALL)
    assert title is not None, done.stderr[-2000:]
    return json.loads(title[1].replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&"))


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
class TestInABrowser:
    def test_text_stands_out_from_what_is_behind_it(self, said: dict[str, Any]) -> None:
        assert said["faint"] == []

    def test_all_that_acts_is_reached_by_keys_and_ringed(self, said: dict[str, Any]) -> None:
        assert said["reached"]
        assert said["unringed"] == []

    def test_a_part_opens_its_scores_and_frames_alone(self, said: dict[str, Any]) -> None:
        assert said["closed"]
        assert said["opened"]
        assert said["others"] == 2, "the part, and the list of parts around it"
        assert "Designed camera" in said["text"]
        assert "tacos-run headset_quick --set 'design.sensor.only=[" in said["text"]
        assert "Designed camera, moment 1" in said["frames"]


@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize("ground", ["paper", "card"])
def test_words_in_the_colour_of_each_camera_stand_out(mode: int, ground: str) -> None:
    behind = luminance(palette._NEUTRALS[ground][mode])
    assert min(ratio(luminance(pair[mode]), behind) for pair in palette._CAMERAS) >= LEAST_TEXT


def luminance(colour: str) -> float:
    """Relative luminance of a colour such as ``#d55e00`` (WCAG 2.2)."""
    parts = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def ratio(one: float, other: float) -> float:
    """Contrast of two luminances (WCAG 2.2)."""
    return (max(one, other) + 0.05) / (min(one, other) + 0.05)


def test_contrast_is_that_of_the_standard() -> None:
    assert ratio(luminance("#000000"), luminance("#ffffff")) == pytest.approx(21)
    assert ratio(luminance("#777777"), luminance("#ffffff")) == pytest.approx(4.48, abs=0.01)
