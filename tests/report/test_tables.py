"""Tables of a page in a browser: sorting, filtering, all rows, saving."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tacos_report.page import Detailed, Page, Section, Table, html_of

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")

ROWS = (
    ("1", "IMX420", Detailed("1.27", "1.19 to 1.34"), "> 99\u202f%"),
    ("2", "AM41", Detailed("−0.5", "-1 to 0"), "87\u202f%"),
    ("3", "Basler, dart", Detailed("12", ""), ""),
    *((str(i), f"part {i}", Detailed(str(i / 10)), f"{i}\u202f%") for i in range(4, 12)),
)
STEPS = """
const rows = () => [...document.querySelectorAll("tbody tr")];
const shown = () => rows().filter((row) => !row.hidden).map((row) => row.cells[1].textContent);
const buttons = [...document.querySelectorAll("button")];
const press = (name) => buttons.find((button) => button.textContent.startsWith(name)).click();
const type = (text) => {
  const field = document.querySelector("input");
  field.value = text;
  field.dispatchEvent(new Event("input"));
};
const said = {};
said.first = shown();
press("Fitness"); said.falling = shown();
said.aria = document.querySelectorAll("th")[2].getAttribute("aria-sort");
press("Fitness"); said.rising = shown();
press("P("); said.chances = shown();
press("Part"); said.words = shown();
press("Show all"); said.all = shown().length;
type("basler"); said.filtered = shown();
type(""); said.unfiltered = shown().length;
said.focusable = [...document.querySelectorAll("th button, input, .tools a")].every((e) => e.tabIndex >= 0);
const link = document.querySelector(".tools a");
link.addEventListener("click", (event) => event.preventDefault());
link.click();
said.file = link.download;
fetch(link.href).then((answer) => answer.text()).then((text) => {
  said.csv = text.split("\\r\\n").filter((line) => /Part|Basler/.test(line));
  document.title = JSON.stringify(said);
});
"""


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_table_is_sorted_filtered_and_saved(tmp_path: Path) -> None:
    table = Table(("", "Part", "Fitness (95 %)", "P(better)"), ROWS, first=3)
    html = html_of(Page("Study", "A finding.", "Its reasons.", [Section("All parts", (table,))]))
    driven = re.sub(r"<meta http-equiv.*?>", "", html).replace("</body>", f"<script>{STEPS}</script></body>")
    (tmp_path / "page.html").write_text(driven, "utf-8")
    command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000"]
    address = f"file://{tmp_path}/page.html"
    done = subprocess.run(
        [*command, f"--user-data-dir={tmp_path}/browser", "--dump-dom", address],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    title = re.search(r"<title>(.*?)</title>", done.stdout, re.DOTALL)
    assert title is not None
    said = json.loads(title[1].replace("&gt;", ">"))
    assert said["first"] == ["IMX420", "AM41", "Basler, dart"]
    assert said["falling"] == ["Basler, dart", "IMX420", "part 11"]
    assert said["aria"] == "descending"
    assert said["rising"] == ["AM41", "part 4", "part 5"]
    assert said["chances"] == ["IMX420", "AM41", "part 11"]
    assert said["words"] == ["AM41", "Basler, dart", "IMX420"]
    assert (said["all"], said["filtered"], said["unfiltered"]) == (11, ["Basler, dart"], 11)
    assert said["focusable"]
    assert said["file"] == "all_parts_1.csv"
    assert said["csv"] == [",Part,Fitness (95 %),P(better)", '3,"Basler, dart",12,']


def test_without_a_script_all_rows_are_there() -> None:
    html = html_of(Page("Study", "A", "B", [Section("C", (Table(("a", "b", "c", "d"), ROWS[:5], first=2),))]))
    assert html.count("<tr>") == 6
    assert "<tr hidden" not in html
