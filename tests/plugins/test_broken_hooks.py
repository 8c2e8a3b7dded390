"""Hooks that raise: a finding of the doctor, a command that is missing, never a traceback of the host."""

from __future__ import annotations

import pytest

from tacos_framework.cli import tacos_main
from tacos_framework.plugins import Plugins

DOCTOR = """
    from tacos_framework import hookimpl
    @hookimpl
    def tacos_doctor():
        BODY
"""

COMMANDS = """
    from tacos_framework import hookimpl
    from tacos_framework.components import Command
    def add_arguments(parser):
        parser.add_argument("--here")
        ADDING
    @hookimpl
    def tacos_commands():
        BODY
        return [Command("shine", "Say something.", add_arguments, lambda arguments: 0)]
"""


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise OSError('no licence server')", "its tacos_doctor failed: OSError: no licence server"),
        ("raise SystemExit(3)", "its tacos_doctor failed: SystemExit: 3"),
        ("return ['all is well']", "it gives a str where a Finding is expected"),
        ("return 7", "its tacos_doctor failed: TypeError"),
    ],
)
def test_a_doctor_that_fails_is_a_finding(distribution, capsys, body, said):
    distribution("acme", DOCTOR.replace("BODY", body))
    (finding,) = [f for f in Plugins.discover().offers.findings() if f.name == "plugin acme"]
    assert not finding.ok
    assert said in finding.value
    assert tacos_main(["doctor"]) == 1
    assert f"BAD  plugin acme: {finding.value}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("adding", "body", "said"),
    [
        ("", "raise OSError('no licence')", "its tacos_commands failed: OSError: no licence"),
        ("", "return ['shine']", "it offers a str where a Command is expected"),
        ("raise OSError('no licence')", "", "its command 'shine' failed: OSError: no licence"),
        ("parser.add_argument('--here')", "", "its command 'shine' failed: ArgumentError"),
    ],
)
def test_commands_that_fail_are_left_out_of_the_help_and_listed(distribution, capsys, adding, body, said):
    distribution("acme", COMMANDS.replace("ADDING", adding).replace("BODY", body))
    with pytest.raises(SystemExit) as ended:
        tacos_main(["--help"])
    assert ended.value.code == 0
    assert "shine" not in capsys.readouterr().out
    assert tacos_main(["plugins"]) == 0
    assert f"broken: plugin acme: {said}" in capsys.readouterr().err


def test_reference_pages_that_fail_are_listed(distribution):
    source = DOCTOR.replace("tacos_doctor", "tacos_reference_pages").replace("BODY", "raise OSError('gone')")
    distribution("acme", source)
    plugins = Plugins.discover()
    assert plugins.offers.reference_pages()
    (failure,) = plugins.failures
    assert failure.reason == "its tacos_reference_pages failed: OSError: gone"
