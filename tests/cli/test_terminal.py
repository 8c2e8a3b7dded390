"""No control character of a file reaches the terminal."""

from __future__ import annotations

import io
import sys

from tacos_framework.cli.exits import WRONG_INPUT, exit_status
from tacos_framework.cli.terminal import printable_output, terminal_errors
from tacos_framework.errors import Fault, UserError, printable

EVIL = "a\x1b]0;title\x07\x1b[2J\r\x9b1m\u202eb\udce9"


def test_what_a_terminal_obeys_is_written_as_escapes():
    assert printable(EVIL) == r"a\x1b]0;title\x07\x1b[2J\r\x9b1m\u202eb\udce9"
    assert printable("tab\tand\nline, Grüße, 画像") == "tab\tand\nline, Grüße, 画像"


def test_faults_show_names_without_obeying_them(capsys):
    def command() -> int:
        raise UserError(Fault(EVIL, EVIL, EVIL, EVIL))

    assert exit_status(command) == WRONG_INPUT
    shown = capsys.readouterr().err
    assert shown.count(printable(EVIL)) == 4
    assert not set(shown) & set("\x1b\x07\r\x9b\u202e\udce9")


def test_what_commands_print_is_printable_and_bars_keep_their_cursor(capsys):
    with printable_output():
        print(EVIL)
        terminal_errors().write("\x1b[2K")
    shown = capsys.readouterr()
    assert shown.out == printable(EVIL) + "\n"
    assert shown.err == "\x1b[2K"
    assert terminal_errors() is sys.stderr


def test_streams_are_given_back_when_a_command_fails(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stdout", stream)
    exit_status(lambda: int(print("x") or 1))
    assert sys.stdout is stream
    assert stream.getvalue() == "x\n"
