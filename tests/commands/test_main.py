"""The command line as a user meets it: help, exit codes, what goes to which stream, and speed."""

import ctypes
import importlib
import io
import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from types import SimpleNamespace

import pytest

import plantigrade
from plantigrade.commands import main as cli
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome, coloured
from plantigrade.errors import FileError

HEAVY = (
    "numpy",
    "scipy",
    "mujoco",
    "matplotlib",
    "websockets",
    "ezc3d",
    "casadi",
    "jinja2",
    "loky",
)
HEAVY += ("llvmlite",)


def python(*words: str, **options) -> subprocess.CompletedProcess:
    """Run a fresh interpreter, as a shell would."""
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, **options)


@pytest.fixture
def command(monkeypatch):
    """Return a function that puts a command ``try``, which does what it is given, on the list."""

    def install(act):
        @dataclass(frozen=True, kw_only=True)
        class Command(PrintOptions):
            """Try something."""

            def run(self) -> Outcome:
                """Do it."""
                return act()

        monkeypatch.setitem(cli.COMMANDS, "try", "Try something.")
        name = "plantigrade.commands.try"
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(Command=Command))

    return install


def test_help_lists_every_command(capsys):
    assert cli.main(["--help"]) == 0
    out, err = capsys.readouterr()
    assert not err
    for name, what in cli.COMMANDS.items():
        assert re.search(rf"^  {name} +{re.escape(what)}$", out, re.M)


def test_no_arguments_is_help(capsys):
    assert cli.main([]) == 0
    assert "usage: plantigrade COMMAND" in capsys.readouterr().out


def test_version(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"plantigrade {plantigrade.__version__}\n"


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_each_command_has_its_help(name, capsys):
    module = importlib.import_module(f"plantigrade.commands.{name}")
    assert module.Command.__doc__.splitlines()[0] == cli.COMMANDS[name]
    assert cli.main([name, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"usage: plantigrade {name}" in out and "--json" in out and "--quiet" in out


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_unknown_option_is_bad_input(name, capsys):
    files = {
        "convert": ["in.trc", "out.mot"],
        "view": ["run"],
        "report": ["run"],
        "retarget": ["run"],
        "picture": ["run", "x.svg"],
    }
    files["synthesize"] = ["walk"]
    needs_a_name = ("fit", "experiment")
    given = files.get(name, ["name"] if name in needs_a_name else [])
    assert cli.main([name, *given, "--no-such-option"]) == 2
    out, err = capsys.readouterr()
    assert not out and "--no-such-option" in err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["dmeo"], "did you mean demo?"),
        (["scale", "dance.bvh"], "`plantigrade fit` scales the human"),
        (["xyzzy"], "there are demo, fit"),
        (["--json", "demo"], "after the command"),
    ],
)
def test_unknown_command_is_bad_input(words, sentence, capsys):
    assert cli.main(words) == 2
    out, err = capsys.readouterr()
    assert not out and sentence in err and len(err.splitlines()) == 1


def test_our_error_is_one_sentence(command, capsys):
    def act():
        raise FileError("walk.c3d", "has no points", remedy="export it with points")

    command(act)
    assert cli.main(["try"]) == 2
    assert capsys.readouterr().err == "error: walk.c3d: has no points — export it with points\n"


def test_a_fault_of_the_system_is_one_sentence(command, capsys, tmp_path):
    command(lambda: (tmp_path / "no" / "such" / "folder").open())
    assert cli.main(["try"]) == 2
    err = capsys.readouterr().err
    assert "No such file" in err and len(err.splitlines()) == 1


def test_a_fault_of_ours_is_not_hidden(command):
    def act():
        raise AssertionError("a bug")

    command(act)
    with pytest.raises(AssertionError, match="a bug"):
        cli.main(["try"])


@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
def test_terminated_is_143(command, capsys):
    before = signal.getsignal(signal.SIGTERM)

    def act():
        os.kill(os.getpid(), signal.SIGTERM)
        Event().wait(10)

    command(act)
    assert cli.main(["try"]) == 143
    err = capsys.readouterr().err
    assert "terminated" in err and len(err.splitlines()) == 1
    assert signal.getsignal(signal.SIGTERM) is before


def test_interrupt_is_130(command, capsys):
    def act():
        raise KeyboardInterrupt

    command(act)
    assert cli.main(["try"]) == 130
    err = capsys.readouterr().err
    assert "interrupted" in err and len(err.splitlines()) == 1


def test_no_valid_result_is_3(command, capsys):
    command(lambda: Outcome("it fell", {"status": "fell at 1.20 s"}))
    assert cli.main(["try"]) == 3
    assert capsys.readouterr().out == "it fell\n"


def test_json_is_alone_on_standard_output(command, capfd):
    def act():
        print("a library chats")
        ctypes.CDLL(None).puts(b"so does its compiled part")
        ctypes.CDLL(None).fflush(None)
        return Outcome("two words", {"status": "ok", "speed_m_s": float("nan"), "steps": 3})

    command(act)
    assert cli.main(["try", "--json"]) == 0
    out, err = capfd.readouterr()
    assert json.loads(out) == {"status": "ok", "speed_m_s": None, "steps": 3}
    for words in ("a library chats", "its compiled part", "two words"):
        assert words in err


def test_standard_output_works_again_afterwards(command, capfd):
    command(lambda: Outcome("first", {"status": "ok"}))
    cli.main(["try", "--json"])
    capfd.readouterr()
    cli.main(["try"])
    assert capfd.readouterr().out == "first\n"


def test_a_reader_that_leaves_early_is_no_error():
    # More text than a pipe holds, so that the writer meets the closed end.
    program = (
        "import sys; from plantigrade.commands import main as m;"
        "m.usage = lambda: 'x\\n' * 200_000; sys.exit(m.main(['--help']))"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 0


def test_module_runs_as_the_program():
    done = python("-m", "plantigrade", "--version")
    assert done.returncode == 0 and done.stdout.strip().endswith(plantigrade.__version__)


@pytest.mark.parametrize(
    "program", ["import plantigrade", "from plantigrade.commands.main import main; main(['-h'])"]
)
def test_nothing_heavy_is_loaded_before_a_command_runs(program):
    check = f"import sys; print([name for name in {HEAVY} if name in sys.modules])"
    done = python("-c", f"{program}\n{check}")
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_nothing_heavy_is_loaded_to_show_the_help_of_a_command(name):
    # beside what the command-line parser itself loads where it is installed
    program = (
        "import sys; import tyro; before = set(sys.modules)\n"
        f"from plantigrade.commands.main import main; main(['{name}', '-h'])\n"
        f"print([name for name in {HEAVY} if name in set(sys.modules) - before])"
    )
    done = python("-c", program)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_one_thread_per_solve_whatever_the_environment_says():
    program = "import os, plantigrade.commands.main; print(os.environ['OMP_NUM_THREADS'])"
    free = {key: value for key, value in os.environ.items() if key != "OMP_NUM_THREADS"}
    assert python("-c", program, env=free).stdout.strip() == "1"
    assert python("-c", program, env=free | {"OMP_NUM_THREADS": "3"}).stdout.strip() == "1"


PIPES = [
    "fit {0}", "fit {1} --static {0}", "fit {1} --forces {0}", "fit {1} --marker-set {0}",
    "fit {1} --norms {0}", "fit {2} --skeleton {0}", "reproduce {0}", "convert {0} a.trc",
    "simulate {0}", "simulate --controller {0}", "simulate --motion {0}", "synthesize {0}",
    "synthesize track --recording {0}", "view {0}", "report {0}", "compare {0} {0}", "picture {0}",
    "train {0}",
]  # fmt: skip


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
@pytest.mark.parametrize("ending", ["", ".c3d", ".toml", ".csv", ".npz", ".py", ".amc"])
@pytest.mark.parametrize("words", PIPES)
def test_a_pipe_is_refused_at_once(words, ending, tmp_path, monkeypatch, capsys):
    """Nobody writes into the pipe: whatever opens it to read would wait for ever."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo(f"pipe{ending}")
    (tmp_path / "empty.trc").write_text("PathFileType\t4\t(X/Y/Z)\n")
    (tmp_path / "empty.amc").write_text(":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n")
    given = words.format(f"pipe{ending}", "empty.trc", "empty.amc").split()
    assert cli.main([*given, *(["--out", "x"] if given[0] in ("fit", "simulate") else [])]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert len(line) <= len("error: ") + 400
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("words", [["fit", "no.c3d"], ["report", "no"], ["simulate", "no.c3d"]])
def test_a_file_that_is_not_there_is_refused_before_libraries_are_loaded(words, tmp_path):
    code = (
        "import sys; from plantigrade.commands.main import main\n"
        f"assert main({words}) == 2\n"
        "assert not {'mujoco', 'scipy.signal', 'scipy.optimize'} & set(sys.modules)"
    )
    root = str(Path(plantigrade.__file__).parents[1])
    done = python("-c", code, cwd=tmp_path, env={**os.environ, "PYTHONPATH": root})
    assert done.returncode == 0 and "there is no such" in done.stderr, done.stderr


def test_a_verdict_is_coloured_on_a_terminal_alone(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.delenv("NO_COLOR", raising=False)
    text = "verdict  CHECK FAILED: too deep"
    assert coloured(text, io.StringIO()) == text
    assert coloured(text, Terminal()) == "verdict  \033[1;31mCHECK FAILED\033[0m: too deep"
    assert "\033[1;32mcheck passed" in coloured("the check passed", Terminal())
    monkeypatch.setenv("NO_COLOR", "1")
    assert coloured(text, Terminal()) == text
