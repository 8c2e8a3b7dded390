"""``tacos predict``."""

from __future__ import annotations

import argparse
from pathlib import Path

from tacos_framework import DONE, Command


def commands() -> list[Command]:
    """The command; importing this is light."""
    return [
        Command(
            "predict",
            "predict what a camera will measure, and check it later",
            _arguments,
            _predict,
        )
    ]


def _arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "source", metavar="RUN_OR_PREDICTION", type=Path, help="results folder, or a prediction"
    )
    parser.add_argument("--out", metavar="FILE", type=Path, help="the new prediction [RUN.prediction.json]")
    parser.add_argument("--about", default="", metavar="TEXT", help="what will be measured, in a sentence")
    parser.add_argument(
        "--measured",
        metavar="PATH",
        type=Path,
        help="what was measured: a table camera,score,value, or a replay",
    )
    parser.add_argument(
        "--register", metavar="DIR", type=Path, action="append", default=[],
        help="folder of own predictions whose misses widen new intervals, beside those that ship",
    )  # fmt: skip


def _predict(arguments: argparse.Namespace) -> int:
    return _measure(arguments) if arguments.measured else _write(arguments)


def _write(arguments: argparse.Namespace) -> int:
    from datetime import datetime

    from tacos_decision.predictions.prediction import SUFFIX
    from tacos_decision.predictions.register import misses_in, model_errors, sentence, shipped_register
    from tacos_decision.predictions.sources import prediction_from
    from tacos_framework.store import read_result

    folder: Path = arguments.source
    errors = model_errors(misses_in([shipped_register(), *arguments.register]))
    now = datetime.now().astimezone()
    prediction = prediction_from(read_result(folder), folder, errors, arguments.about, now)
    out = arguments.out or folder.with_name(f"{folder.name}{SUFFIX}")
    prediction.write(out)
    for value in prediction.values:
        print(
            f"  {value.camera:20} {value.score:28} {value.value:9.4g}  ({value.low:.4g} to {value.high:.4g})"
        )
    print(sentence(dict.fromkeys(value.kind for value in prediction.values), errors))
    print(f"{out}, SHA-256 {prediction.digest[:16]}: commit it before you measure.")
    return DONE


def _measure(arguments: argparse.Namespace) -> int:
    from datetime import datetime

    from tacos_decision.predictions.outcome import SUFFIX, hold_against, not_predicted, write_outcome
    from tacos_decision.predictions.prediction import SUFFIX as PREDICTION
    from tacos_decision.predictions.prediction import read_prediction
    from tacos_decision.predictions.sources import measured_in
    from tacos_framework.store import read_result

    path, measured = arguments.source, arguments.measured
    prediction = read_prediction(path)
    result = read_result(measured) if measured.is_dir() else None
    values = measured_in(measured, result)
    outcome = hold_against(prediction, values, str(measured))
    if result is None:  # a replay also measures the exposure it starts from
        print(*(f"  {each}\n" for each in not_predicted(prediction, values)), sep="", end="")
    for miss in outcome.misses:
        value = miss.predicted
        said = "inside" if miss.inside else "outside"
        print(
            f"  {value.camera:20} {value.score:28} {value.value:9.4g}  measured {miss.measured:.4g}, {said}"
        )
    for score, tau in outcome.tau.items():
        print(f"{score}: " + ("one camera has no order" if tau is None else f"Kendall's tau {tau:.2f}"))
    print(f"{outcome.coverage:.0%} of {len(outcome.misses)} values inside their 90 % intervals")
    out = path.with_name(path.name.removesuffix(PREDICTION) + SUFFIX)
    write_outcome(out, outcome, prediction, datetime.now().astimezone().isoformat(timespec="seconds"))
    print(out)
    return DONE
