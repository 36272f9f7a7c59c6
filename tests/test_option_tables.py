"""The tables of options in the documentation hold what the command line takes."""

import re

import pytest

pytest.importorskip("docutils")

from plantigrade.commands.main import COMMANDS, parse  # noqa: E402
from plantigrade.control import CONTROLLERS  # noqa: E402
from tests.test_pages_of_docs import extension  # noqa: E402

TABLES = extension("option_tables")


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "synthesize"])
def test_every_option_of_the_help_is_in_one_row(command, capsys):
    with pytest.raises(SystemExit):
        parse(command, ["--help"])
    helped = set(re.findall(r"^│ (--[a-z-]+)|, (--help)", capsys.readouterr().out, re.M))
    groups = TABLES.groups(TABLES.command_class(command))
    names = [row.name.split()[0] for group in groups for row in group.rows]
    options = [name for name in names if name.startswith("--")]
    assert len(options) == len(set(options))
    assert {name for name, _ in helped if name} <= {*options}
    assert all(row.meaning for group in groups for row in group.rows)


def test_a_row_has_the_default_and_what_is_allowed():
    groups = TABLES.groups(TABLES.command_class("synthesize", "walk"))
    own = {row.name: row for row in groups[0].rows}
    assert groups[0].title == TABLES.OWN
    assert own["--speed FLOAT"].default == "1.3"
    assert own["--speed FLOAT"].allowed == "0.3 to 2.2 m/s"
    assert own["--slope DEG"].allowed == "−20 to 20 degrees"
    shared = {row.name: row for group in groups[1:] for row in group.rows}
    assert shared["--solver"].allowed == "interior-point, ipopt"
    assert shared["--height METRES"].default == ""


def test_an_argument_that_must_be_given_is_first():
    (first, *_), *_ = (group.rows for group in TABLES.groups(TABLES.command_class("fit")))
    assert first.name == "FILE|FOLDER ..." and first.default == "required"


@pytest.mark.parametrize("name", CONTROLLERS)
def test_settings_of_a_controller_come_by_component(name):
    groups = TABLES.settings(name)
    for group in groups:
        assert all(row.name.rpartition(".")[0] == group.title for row in group.rows)
        assert all(row.meaning for row in group.rows)


def test_a_table_has_a_line_for_each_row():
    group = TABLES.groups(TABLES.command_class("report"))[0]
    text = TABLES.table(group.rows, TABLES.HEADS).astext()
    assert all(row.name in text and row.meaning in text for row in group.rows)
