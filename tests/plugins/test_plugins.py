"""Discovery: broken plugins are kept, listed, and matter only when they are needed."""

from __future__ import annotations

import pytest

from tacos_framework.components import Component
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.plugins.contract_check import contract_faults

GOOD = """
    from tacos_framework import Component, hookimpl
    @hookimpl
    def tacos_components():
        return [Component("task", "NAME", "MODULE:Nothing", summary="A task.")]
"""


def good(name, module):
    return GOOD.replace("NAME", name).replace("MODULE", module)


def test_the_defaults_come_in_by_the_same_door_as_anyone():
    plugins = Plugins.discover()
    assert plugins.failures == []
    registered = {r.component.use: r.distribution for r in plugins}
    assert registered["renderer.moderngl"] == "tacos-framework"


def test_a_good_plugin_is_found(distribution):
    distribution("good-plugin", good("fine", "good_plugin"))
    found = {r.component.use: r.distribution for r in Plugins.discover()}
    assert found["task.fine"] == "good-plugin"


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        (
            "import not_there_at_all",
            "its import failed: ModuleNotFoundError: No module named 'not_there_at_all'",
        ),
        ("raise RuntimeError('no licence')", "its import failed: RuntimeError: no licence"),
        ("def broken(:", "its import failed: SyntaxError"),
        (
            """
            from tacos_framework import hookimpl
            @hookimpl
            def tacos_components():
                return ["task.words"]
            """,
            "it offers a str where a Component is expected",
        ),
        (
            """
            from tacos_framework import hookimpl
            @hookimpl
            def tacos_components():
                return 1 / 0
            """,
            "its tacos_components failed: ZeroDivisionError",
        ),
        (
            """
            from tacos_framework import hookimpl
            @hookimpl
            def tacos_components(wrong_argument):
                return []
            """,
            "its hooks do not fit",
        ),
        (
            """
            from tacos_framework import Component, hookimpl
            @hookimpl
            def tacos_components():
                return [Component("task", "old", "x:Y", summary="Old.", contract=0)]
            """,
            "task.old is written for contract 0, this is 1",
        ),
        (
            """
            from tacos_framework import Component, hookimpl
            @hookimpl
            def tacos_components():
                return [Component("lens", "wide", "x:Y", summary="A kind there is not.")]
            """,
            "component kind 'lens' is not one of",
        ),
    ],
)
def test_a_broken_plugin_is_kept_with_its_reason_and_the_others_work(distribution, source, reason):
    distribution("zz-broken", source)
    distribution("good-plugin", good("fine", "good_plugin"))
    plugins = Plugins.discover()
    (failure,) = plugins.failures
    assert failure.plugin == "zz-broken"
    assert reason in failure.reason
    assert plugins.component("task.fine").name == "fine"
    assert plugins.component("sensor.affine-noise").target.startswith("tacos_plugins.")


def test_a_missing_component_names_the_nearest_and_the_broken_plugin(distribution):
    distribution("zz-broken", "import not_there_at_all")
    with pytest.raises(UserError) as caught:
        Plugins.discover().component("task.orb-featurs", "task")
    message = str(caught.value)
    assert "no component 'task.orb-featurs' is installed" in message
    assert "Did you mean 'task.orb-features'?" in message
    assert "plugin zz-broken is unusable: its import failed" in message


def test_an_optional_package_that_is_missing_is_named():
    plugins = Plugins()

    class Offer:
        @hookimpl
        def tacos_components(self):
            return [
                Component("task", "deep", "x:Y", summary="Deep.", requires=("not_there_at_all=big-package",))
            ]

    plugins.register(Offer())
    with pytest.raises(UserError, match="pip install big-package"):
        plugins.resolve("task.deep")


def test_an_import_error_inside_a_component_passes_unchanged_with_a_note():
    plugins = Plugins()

    class Offer:
        @hookimpl
        def tacos_components(self):
            return [Component("task", "gone", "not_there_at_all.module:Class", summary="Gone.")]

    plugins.register(Offer())
    with pytest.raises(ModuleNotFoundError) as caught:
        plugins.resolve("task.gone")
    assert "task.gone" in caught.value.__notes__[0]


def test_a_class_that_does_not_fit_its_kind_is_refused_with_all_it_lacks():
    class NoTask:
        pass

    faults = contract_faults(Component("task", "none", "x:NoTask", summary="None."), NoTask)
    assert faults == [
        "NoTask has no method begin",
        "NoTask.Config is not a tacos_framework.settings.Settings class",
        "NoTask has no class attribute scores",
    ]


def test_every_default_component_fits_its_contract():
    plugins = Plugins.discover()
    resolved = [plugins.resolve(r.component.use) for r in plugins if not r.component.missing_packages()]
    assert len(resolved) > len(list(plugins)) - 3  # extras as large as Blender need not be installed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "lens"}, "component kind 'lens' is not one of scene, rig"),
        ({"name": "Orb Features"}, "is not lower-case words joined by hyphens"),
        ({"target": "module.Class"}, "is not of the form 'package.module:Class'"),
        ({"summary": ""}, "has no summary"),
    ],
)
def test_descriptors_refuse_nonsense_in_a_sentence(changes, message):
    good = {"kind": "task", "name": "orb", "target": "m:C", "summary": "S."}
    with pytest.raises(ValueError, match=message):
        Component(**{**good, **changes})
