"""Text on its way to the terminal."""

import json

from ertel.apps import output, tables


def test_tables_show_no_control_characters(capsys):
    tables.console().print("a\x1b[31mb")
    assert capsys.readouterr().out == "a\\x1b[31mb\n"


def test_json_reads_back_in_any_terminal(capsys):
    content = {"name": "Öl\x1b µ"}
    output.print_json(content)
    printed = capsys.readouterr().out
    assert printed.isascii()
    assert json.loads(printed) == content
