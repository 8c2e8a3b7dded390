"""What the parts of a camera cost together."""

from __future__ import annotations

from tacos_report.analysis import RankedPart
from tacos_report.page import Detailed, Table
from tacos_report.prices import price_words
from tacos_report.sections import purchase, ranking
from tacos_report.study_data import Analysis, CameraResult, StudyData

SENSOR = {"name": "IMX219", "price_eur": 40.0}
LENS = {"name": "DSL219", "price_eur": 210.0}


def said(**camera: object) -> str:
    return price_words(camera).replace("\u202f", " ")


def test_prices_of_all_parts_are_added_up() -> None:
    assert said(sensor=SENSOR, lens=LENS, pitch_deg=3.0) == "250 EUR: sensor 40 EUR, lens 210 EUR"


def test_a_price_that_is_lacking_makes_the_sum_the_least() -> None:
    unknown = {"name": "DSL219", "price_eur": None}
    lacking = "at least 40 EUR: sensor 40 EUR; not stated of lens"
    assert said(sensor=SENSOR, lens=unknown) == lacking
    assert said(sensor=SENSOR, focal_length_mm=2.0) == lacking


def test_a_price_by_itself_says_of_what_it_is() -> None:
    """Other parts may be fixed, and so stand in no variable."""
    assert said(lens=LENS, pitch_deg=3.0) == "lens 210 EUR"


def test_currencies_are_not_converted() -> None:
    assert said(sensor={"price_usd": 9.5}, lens=LENS).startswith("9.5 USD and 210 EUR: ")


def test_without_a_price_nothing_is_said() -> None:
    assert said(sensor={"name": "IMX219"}, lens={"name": "x", "price_eur": None}) == ""


def test_what_to_buy_and_the_ranking_have_the_sum() -> None:
    camera = {"sensor": SENSOR, "lens": LENS}
    ranked = (RankedPart("IMX219", camera, 1.0, (0.9, 1.1), {}, True, 3, ()),)
    designed = CameraResult("designed", "Designed camera", camera, {})
    study = StudyData({}, (designed,), (), analysis=Analysis(ranking=ranked))
    together = [block for block in purchase.blocks(study) if isinstance(block, Table)]
    assert together[0].rows[0] == ("Price of one of each", price_words(camera))
    table = next(block for block in ranking.blocks(study) if isinstance(block, Table))
    optics = table.rows[0][2]
    assert isinstance(optics, Detailed)
    assert optics.detail == price_words(camera)
