"""The page on controllers runs as printed."""

from pathlib import Path

from plantigrade.commands.main import parse
from tests.paste import commands, run_code

PAGE = Path(__file__).resolve().parents[1] / "docs" / "controllers.md"


def test_the_code_of_the_page_runs(capsys):
    run_code(PAGE)
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["ok", "0.05"]


def test_the_commands_of_the_page_exist():
    for words in commands(PAGE, "bash"):
        if "--help" not in words:
            parse(words[1], words[2:])
