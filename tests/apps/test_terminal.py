"""Text on its way to the terminal."""

import json

import pytest

from ertel.apps import tables, terminal
from ertel.apps.terminal import in_shell


def test_tables_show_no_control_characters(capsys):
    tables.console().print("a\x1b[31mb")
    assert capsys.readouterr().out == "a\\x1b[31mb\n"


def test_json_reads_back_in_any_terminal(capsys):
    content = {"name": "Öl\x1b µ"}
    terminal.print_json(content)
    printed = capsys.readouterr().out
    assert printed.isascii()
    assert json.loads(printed) == content


@pytest.mark.parametrize(("name", "word"), [("a b", "'a b'"), ("-x", "./-x"), ("plain", "plain")])
def test_a_path_in_advice_is_one_word_of_a_command(tmp_path, monkeypatch, name, word):
    monkeypatch.chdir(tmp_path)
    assert in_shell(tmp_path / name) == word
