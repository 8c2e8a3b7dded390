"""The page that shows what each photograph was taken for."""

from __future__ import annotations

import re

import numpy as np

from tacos_framework.cli import tacos_main
from tests.gap.photographs.test_caps_and_walls import FALL_OFF, SHAPE, save


def test_each_picture_stands_under_its_kind_with_what_was_guessed(tmp_path, capsys):
    for k in range(6):
        save(tmp_path / "in", f"cap_{k}_10ms", np.full(SHAPE, 16.0), k)
    save(tmp_path / "in", "wall_1-250s", 16 + 120 * FALL_OFF, 9)
    assert tacos_main(["captures", "import", str(tmp_path / "in"), "--out", str(tmp_path / "out")]) == 0
    assert f"Look: tacos captures view {tmp_path / 'out'}" in capsys.readouterr().out
    assert tacos_main(["captures", "view", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'out/contact_sheet.html'}: 2 captures: 1 dark, 1 flat\n"
    page = (tmp_path / "out/contact_sheet.html").read_text()
    assert len(re.findall("<img", page)) == 5  # four caps and a wall
    assert page.index("dark: 6 pictures") < page.index("flat: 1 picture<")
    assert "cap_0_10ms.png: dark_1, one of 6, 10 ms" in page
    assert "wall_1-250s.png: flat_1, 4 ms" in page
    assert "The pixels are taken to be 3 um" in page
    assert not re.search(r"(src|href)=.https?:", page)


def test_a_missing_picture_is_named_and_no_page_is_written(tmp_path, capsys):
    save(tmp_path / "in", "wall_4ms", np.full(SHAPE, 120.0), 1)
    tacos_main(["captures", "import", str(tmp_path / "in"), "--out", str(tmp_path / "out")])
    (tmp_path / "out/flat_1/wall_4ms.png").unlink()
    assert tacos_main(["captures", "view", str(tmp_path / "out")]) == 2
    assert "there is no file 'wall_4ms.png'" in capsys.readouterr().err
    assert not (tmp_path / "out/contact_sheet.html").exists()
