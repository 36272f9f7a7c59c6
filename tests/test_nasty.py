"""The command that damages files: what it calls a finding, and that it finds the same again."""

import subprocess
import sys

import pytest

from plantigrade.errors import FileError, ParameterError
from tests import nasty
from tests.nasty import seeds
from tests.nasty.judge import outcome
from tests.nasty.targets import TARGETS, BadValue, Target


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (None, "read"),
        (FileError("a.txt", "is wrong", remedy="mend it"), "refused"),
        (ParameterError("speed is too high"), "refused"),
        (FileError("a.txt", "is wrong"), "bad message"),
        (FileError("/elsewhere/b.txt", "is wrong", remedy="mend it"), "bad message"),
        (ParameterError("two\nlines"), "bad message"),
        (ParameterError("a \x1b[2J b"), "bad message"),
        (ParameterError("<ast.BinOp object at 0x7f3b3b272ce0> is wrong"), "bad message"),
        (ParameterError(), "bad message"),
        (BadValue("time stands still"), "bad value"),
        (KeyError("x"), "foreign exception"),
        (RuntimeWarning("overflow"), "foreign exception"),
        (MemoryError(), "memory"),
    ],
)
def test_what_is_a_finding(tmp_path, monkeypatch, error, kind):
    monkeypatch.chdir(tmp_path)

    def read(_):
        if error is not None:
            raise error

    path = seeds.text("a.txt", "1 2\n")(tmp_path)
    found = outcome(Target("toy", read, seeds.text("a.txt", "")), path.relative_to(tmp_path))
    assert found.kind == kind and found.is_finding == (kind not in ("read", "refused"))


@pytest.mark.parametrize("name", ["TRC", "npz", "figures", "C3D"])
def test_a_mutant_depends_on_its_name_alone(tmp_path, name):
    target = TARGETS[name]
    raw = target.make(tmp_path).read_bytes()
    for _, content in nasty.mutants("a", raw, target.ways, 20):
        assert isinstance(content, bytes)
    first, again, other = (list(nasty.mutants(n, raw, target.ways, 20)) for n in "aab")
    assert first == again != other


def call(*words) -> subprocess.CompletedProcess:
    words = (sys.executable, "-m", "tests.nasty", *map(str, words))
    return subprocess.run(words, capture_output=True, text=True)


@pytest.mark.slow
def test_the_command_finds_what_is_broken_and_goes_on(tmp_path):
    """A reader that hangs, crashes, takes all memory, writes files, or raises anything."""
    done = call("--targets", "broken: *", "norms", "--mutants", 55, "--jobs", 1, "--keep", tmp_path)
    assert done.returncode == 1, done.stderr
    for kind in ("hang: ", "crash: SIGSEGV", "foreign exception: KeyError", "files: ", "memory: "):
        assert kind in done.stdout
    assert "55 mutants" in done.stdout
    line = next(
        line for line in done.stdout.splitlines() if "--again" in line and "foreign" in line
    )
    again = call(*[word.strip("'") for word in line.split("tests.nasty ")[1].split(" ", 3)])
    assert again.returncode == 1 and "KeyError" in again.stdout


@pytest.mark.slow
def test_the_command_reports_in_one_table(tmp_path):
    done = call("--targets", "norms", "figures", "--mutants", 300, "--jobs", 2, "--keep", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    table = done.stdout.splitlines()
    assert table[0].startswith("300 mutants in") and not list(tmp_path.iterdir())
    assert [line.split()[:2] for line in table[2:]] == [
        ["norms", "150"], ["figures", "150"], ["together", "300"],
    ]  # fmt: skip
