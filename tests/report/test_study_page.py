"""The page as a whole: what it says, that it stands alone, that it bears with what is missing."""

from __future__ import annotations

import base64
import hashlib
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from tacos_framework.errors import UserError
from tacos_report import write_report
from tests.report.results_folder import write_json, write_results

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
_VOID = {"meta", "img", "br", "image", "path", "use", "rect", "polygon", "link", "input"}


class Page(HTMLParser):
    """Reads a page: its tags with attributes, its text, and whether every tag is closed in order."""

    def __init__(self, html: str):
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._open: list[str] = []
        self.feed(html)
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in _VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if tag not in _VOID:
            assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open[-1:] != ["script"]:
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_results(tmp_path_factory.mktemp("results"))


@pytest.fixture(scope="module")
def html(folder: Path) -> str:
    return write_report(folder).read_text("utf-8")


@pytest.fixture
def report_of(folder: Path, tmp_path: Path) -> Callable[..., str]:
    """The report of the complete folder with changes to its result; generations only where asked for."""

    def report(change: Callable[[dict[str, Any]], None] = lambda result: None, generations: str = "") -> str:
        result = json.loads((folder / "result.json").read_text("utf-8"))
        result["samples"] = {}
        change(result)
        write_json(tmp_path, result)
        (tmp_path / "generations.jsonl").write_text(generations, "utf-8")
        return write_report(tmp_path).read_text("utf-8")

    return report


def test_the_page_answers_first_and_has_every_part(html: str) -> None:
    page = Page(html)
    headline = page.text[page.text.index("The best camera found") :]
    assert headline.startswith("The best camera found: the PYTHON1300 sensor behind a 2.36 mm lens")
    assert "fitter than the Luxonis OAK-D Pro Wide, the best of 3 off-the-shelf cameras" in page.text
    for part in (
        "same moments", "What each camera sees", "none of them was tuned on", "The search",
        "design space explored", "Where the time went", "Repeat this run", "an eighth of its pixels",
        "tacos-run headset_quick --out runs/headset", "llvmpipe", "scene.indoor",
    ):  # fmt: skip
        assert part in page.text


def test_the_page_stands_alone(html: str) -> None:
    page = Page(html)
    assert "http" not in html.replace("http-equiv", "")
    policy = next(attrs["content"] for tag, attrs in page.tags if tag == "meta" and "http-equiv" in attrs)
    assert policy.startswith("default-src 'none'; img-src data:;")
    script = html[html.index("<script>") + len("<script>") : html.index("</script>")]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert policy.endswith(f"script-src 'sha256-{digest}'")  # no other may run
    assert [attrs for tag, attrs in page.tags if tag == "script"] == [{}]
    assert "url(" not in html.replace("url(#", "")
    assert not {"link", "iframe"} & {tag for tag, _ in page.tags}
    sources = [
        attrs.get("src") or attrs.get("href") for tag, attrs in page.tags if tag in {"img", "image", "use"}
    ]
    assert sources
    assert all(source and source.startswith(("data:image/", "#")) for source in sources)


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_the_policy_blocks_nothing_of_our_own_and_every_script(folder: Path, tmp_path: Path) -> None:
    html = (folder / "report.html").read_text("utf-8")
    evil = html.replace(
        "</body>", '<script>document.title="run"</script><img src="http://127.0.0.1:9/x"></body>'
    )
    said = {}
    for name, text in (("own", html), ("evil", evil)):
        (tmp_path / f"{name}.html").write_text(text)
        command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
        done = subprocess.run(
            [*command, "--enable-logging=stderr", f"--user-data-dir={tmp_path}", f"file://{tmp_path}/{name}.html"],
            capture_output=True, text=True, timeout=60, check=True,
        )  # fmt: skip
        said[name] = done.stderr
        assert "<title>run" not in done.stdout
    assert "Content Security Policy" not in said["own"]
    assert said["evil"].count("Content Security Policy") >= 2


def test_every_picture_is_described_and_ids_are_unique(html: str) -> None:
    page = Page(html)
    assert all(attrs.get("alt") for tag, attrs in page.tags if tag == "img")
    drawings = [attrs for tag, attrs in page.tags if tag == "svg"]
    assert len(drawings) == 12, "four of the eight once more, for phones"
    assert all(attrs["role"] == "img" and attrs["aria-label"] for attrs in drawings)
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert len(ids) == len(set(ids))
    references = {attrs["href"] for tag, attrs in page.tags if tag == "use"}
    assert references <= {f"#{name}" for name in ids}


def test_equal_results_give_equal_bytes(folder: Path, html: str) -> None:
    assert write_report(folder).read_text("utf-8") == html


def test_what_users_name_is_escaped(report_of: Callable[..., str]) -> None:
    evil = "<script>alert(1)</script> $\\bad$"

    def change(result: dict[str, Any]) -> None:
        result.update(name=evil, notes=[evil], command=evil, stopped=evil)
        result["cameras"]["flea3"]["title"] = evil
        result["best"]["camera"]["sensor"]["name"] = evil
        result["cameras"]["designed"]["camera"]["sensor"]["name"] = evil
        result["seconds_by_node"] = {evil: 1.0}
        result["fitness"] = [{"score": evil, "weight": 1}]
        result["environment"]["gl_renderer"] = evil

    line = {"generation": 0, "frames": 1, "candidates": [
        {"camera": {"sensor": {"name": evil}}, "fitness": None, "failed": evil},
        {"camera": {"sensor": {"name": evil}}, "fitness": 1.0, "derived": {evil: 1.0}},
    ]}  # fmt: skip
    text = report_of(change, json.dumps(line))
    assert text.count("<script") == 1  # the page's own
    assert text.count("&lt;script&gt;") > 8


def test_without_a_comparison_there_is_no_talk_of_others(report_of: Callable[..., str]) -> None:
    def change(result: dict[str, Any]) -> None:
        result["cameras"] = {"designed": result["cameras"]["designed"]}
        result["test"] = {"designed": result["test"]["designed"]}

    text = Page(report_of(change)).text
    assert "The recipe names no camera to compare it with" in text
    assert "off-the-shelf" not in text
    assert "Change" not in text


def test_a_study_stopped_before_its_test_says_so(report_of: Callable[..., str]) -> None:
    def change(result: dict[str, Any]) -> None:
        result.update(test={}, stopped="interrupted by the user")
        for camera in result["cameras"].values():
            camera.update(terms={}, spread={})

    text = Page(report_of(change)).text
    assert "It has not been tried on unseen scenes: the study ended before its test." in text
    assert "The search ended: interrupted by the user" in text


def test_a_study_without_any_success_says_so_and_why(report_of: Callable[..., str]) -> None:
    def change(result: dict[str, Any]) -> None:
        result.update(test={}, cameras={}, best=None)

    failed = [
        {"camera": {"pitch_deg": 1.0}, "fitness": None, "failed": f"hfov_deg is {v}"} for v in (150, 160)
    ]
    text = Page(report_of(change, json.dumps({"generation": 0, "frames": 0, "candidates": failed}))).text
    assert "No camera was found: not one candidate could be scored." in text
    assert "None of 2 candidates could be scored." in text
    assert "2 hfov_deg is 150" in text


def test_the_barest_result_still_makes_a_page(tmp_path: Path) -> None:
    write_json(tmp_path, {})
    assert "No camera was found" in Page(write_report(tmp_path).read_text("utf-8")).text


def test_a_stereo_rig_shows_its_baseline(report_of: Callable[..., str]) -> None:
    def change(result: dict[str, Any]) -> None:
        result["cameras"]["designed"]["camera"] = {"baseline_m": 1.84, "hfov_deg": 50.0}
        result["cameras"]["designed"]["derived"] = {"hfov_deg": 50.0, "vfov_deg": 26.0}

    text = Page(report_of(change)).text
    assert "baseline 1.84 m" in text


def test_samples_outside_the_folder_are_not_embedded(folder: Path, report_of: Callable[..., str]) -> None:
    outside = str(folder / "samples" / "designed_0.png")
    text = report_of(lambda result: result.update(samples={"designed": [outside, "../secret.png"]}))
    assert "data:image" not in text


def test_an_unreadable_sample_is_left_out(report_of: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "broken.png").write_bytes(b"no picture")
    assert "data:image" not in report_of(lambda result: result.update(samples={"designed": ["broken.png"]}))


def test_a_torn_last_generation_is_left_out_and_said(
    report_of: Callable[..., str], caplog: pytest.LogCaptureFixture
) -> None:
    whole = json.dumps({"generation": 0, "frames": 9, "candidates": [{"camera": {"x": 1.0}, "fitness": 2.0}]})
    text = Page(report_of(generations=f"{whole}\n{whole[:30]}")).text
    assert "The highest of 1 score came in generation 1 of 1." in text
    assert "generations.jsonl: the last line was cut short and is left out" in caplog.text


def test_a_torn_line_in_the_middle_is_the_users_to_know(report_of: Callable[..., str]) -> None:
    with pytest.raises(UserError, match=r"generations\.jsonl: the file is damaged: line 1: it is no JSON"):
        report_of(generations='{"generation"\n{}\n')


def test_a_folder_without_a_result_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"there is no result\.json here") as caught:
        write_report(tmp_path)
    assert caught.value.faults[0].where == str(tmp_path)


def test_importing_the_package_loads_no_drawing_code() -> None:
    code = "import sys, tacos_report; print('matplotlib' in sys.modules, 'jinja2' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
