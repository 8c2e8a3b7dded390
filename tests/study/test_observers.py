"""Observers are told, and change nothing, whatever they do and however they fail."""

from __future__ import annotations

import pytest
import toy_plugin
from toy_study import comparable, run, toy_recipe

from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins

HOOKS = ("tacos_study_started", "tacos_generation_finished", "tacos_candidate_failed", "tacos_study_finished")


class Recorder:
    """Keeps what it is told."""

    def __init__(self):
        self.told = []

    @hookimpl
    def tacos_study_started(self, recipe, out):
        self.told.append(("started", recipe.name, out.is_dir()))

    @hookimpl
    def tacos_generation_finished(self, generation, evaluated, best):
        self.told.append(("generation", generation, len(evaluated), best.fitness))

    @hookimpl
    def tacos_candidate_failed(self, candidate, reason):
        self.told.append(("failed", set(candidate), reason))

    @hookimpl
    def tacos_study_finished(self, result):
        self.told.append(("finished", result["stopped"]))


class Vandal:
    """Clears all it is given."""

    @hookimpl
    def tacos_study_started(self, recipe):
        recipe.design.clear()
        recipe.nodes["width"].inputs.clear()

    @hookimpl
    def tacos_generation_finished(self, evaluated, best):
        for evaluation in evaluated:
            for part in (evaluation.values, evaluation.scores, evaluation.terms, evaluation.derived):
                part.clear()
        best.scores.clear()
        best.values.clear()
        evaluated.clear()

    @hookimpl
    def tacos_candidate_failed(self, candidate):
        candidate.clear()

    @hookimpl
    def tacos_study_finished(self, result):
        result.clear()


def raising(hook, error):
    """An observer that raises in one hook and notes when it is called at all."""

    def raises(self, **told):
        self.calls += 1
        raise error

    return type("Raising", (), {"calls": 0, hook: hookimpl(lambda self: raises(self))})()


def observed(*observers):
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    for number, observer in enumerate(observers):
        plugins.register(observer, f"observer-{number}")
    return plugins


RECIPE = {"nodes": {"width": {"fail_above_deg": 110}}, "study": {"renew_episodes": "never"}}


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The result of a study that nobody watches."""
    return comparable(run(toy_recipe(**RECIPE), observed(), tmp_path_factory.mktemp("alone")))


def test_an_observer_is_told_of_each_step(tmp_path, alone):
    recorder = Recorder()
    result = run(toy_recipe(**RECIPE), observed(recorder), tmp_path)
    assert comparable(result) == alone
    assert recorder.told[0] == ("started", "toy", True)
    assert [told[1:3] for told in recorder.told if told[0] == "generation"] == [(i, 6) for i in range(4)]
    assert any(told[0] == "failed" and told[2].startswith("cannot judge") for told in recorder.told)
    assert recorder.told[-1] == ("finished", result["stopped"])


def test_one_that_clears_all_it_is_given_changes_nothing_for_the_study_or_others(tmp_path, alone):
    recorder, unwatched = Recorder(), Recorder()
    result = run(toy_recipe(**RECIPE), observed(Vandal(), recorder), tmp_path / "vandal")
    assert comparable(result) == alone
    run(toy_recipe(**RECIPE), observed(unwatched), tmp_path / "other")
    assert recorder.told == unwatched.told


@pytest.mark.parametrize("error", [OSError("no connection"), SystemExit(3)], ids=["raises", "exits"])
@pytest.mark.parametrize("hook", HOOKS)
def test_one_that_raises_is_switched_off_with_one_warning(tmp_path, alone, caplog, hook, error):
    broken, recorder = raising(hook, error), Recorder()
    result = run(toy_recipe(**RECIPE), observed(broken, recorder), tmp_path)
    assert comparable(result) == alone
    assert broken.calls == 1
    assert recorder.told[-1][0] == "finished"
    warning = (
        f"the observer observer-0 is switched off, as its {hook} raised {type(error).__name__}: {error}; "
        "the study goes on without it"
    )
    assert [record.getMessage() for record in caplog.records].count(warning) == 1
    assert (tmp_path / "log.txt").read_text().count(warning) == 1


def test_the_warning_names_the_distribution(tmp_path, distribution, caplog):
    distribution(
        "acme-tracker",
        """
        from tacos_framework import hookimpl
        @hookimpl
        def tacos_generation_finished(best):
            raise OSError("no connection")
        """,
    )
    run(toy_recipe(**RECIPE), observed(), tmp_path / "out")
    assert "the observer acme_tracker of acme-tracker is switched off" in caplog.text


def test_a_doctor_that_raises_is_a_finding_of_the_study(tmp_path, alone):
    class Doctor:
        @hookimpl
        def tacos_doctor(self):
            raise OSError("no licence server")

    result = run(toy_recipe(**RECIPE), observed(Doctor()), tmp_path)
    assert comparable(result) == alone
    said = result["environment"]["findings"]["plugin observer-0"]
    assert said == "its tacos_doctor failed: OSError: no licence server"
