"""The command line: find the command, load its module alone, run it, print what it returns.

Nothing heavy is imported here, so that ``plantigrade --help`` answers at once. Exit codes: 0 done;
2 bad input; 3 the method did not reach a valid result (the run folder is still written and its
``status`` says what failed); 130 interrupted from the keyboard; 143 terminated (SIGTERM).
"""

import atexit
import contextlib
import gc
import glob
import importlib
import io
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

# One thread per solve: with a busy core, the worker threads of OpenMP and OpenBLAS slow the small
# matrices of a human body two- to threefold, and sums in another order end in other last digits.
# Parallelism is over runs, not inside them. It must be said before numpy is loaded, whatever the
# environment says: equal commands give equal bytes.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = "1"

from plantigrade import __version__  # noqa: E402
from plantigrade.commands.outcome import Outcome, coloured  # noqa: E402
from plantigrade.errors import (  # noqa: E402
    CheckoutNeeded,
    FileError,
    PlantigradeError,
    did_you_mean,
)
from plantigrade.interrupts import on_signal  # noqa: E402
from plantigrade.printable import printable  # noqa: E402

GC_THRESHOLD = 300_000
"""New objects between two garbage collections [1]. Python's 700 makes it search for cycles hundreds
of times while modules are loaded, a twentieth of a synthesis; with 100 000 two searches take 60 ms
of a periodic walk, and with 300 000 none is needed, for 8 MB more memory in use of 330."""
_KEPT = "no incomplete run folder is kept; a batch continues with the same command"
# Exit codes; the last two are those of a shell for SIGINT and SIGTERM.
DONE, BAD_INPUT, NO_RESULT, INTERRUPTED, TERMINATED = 0, 2, 3, 130, 143

COMMANDS = {
    "demo": "Run the whole pipeline on built-in data and say where the results are.",
    "fit": "Fit a scaled human to a recording: motion, ground reactions and joint moments.",
    "reproduce": "Reproduce a recorded gait from three prioritised tasks; several make a study.",
    "synthesize": "Generate a motion from a task description by trajectory optimisation.",
    "simulate": "Simulate a person, standing or moving, under a controller.",
    "train": "Train a walking policy on a reference walk by reinforcement learning.",
    "vault": "Optimise a gymnast's vault: the joint activations that give the fastest take-off.",
    "convert": "Convert a motion file, or a run, to another format.",
    "retarget": "Put the motion of a run on a robot, an MJCF model with two legs.",
    "model": "Write a human as MJCF or OpenSim model, or print its segments, joints and strengths.",
    "view": "Show a run as an interactive 3-D scene in the browser.",
    "report": "Write the report and viewer pages of a run again.",
    "compare": "Compare walks: overlaid curves and differences with confidence bands, on one page.",
    "norms": "Compute norms from your own runs: mean and standard deviation over people.",
    "picture": "Draw a run as an animated SVG, or as a strip of still frames.",
    "experiment": "Recompute a published table or figure, our numbers and the published ones.",
    "data": "List the recordings in a folder and their contents, or download public ones.",
}
"""Every command in the order of the help page; each is a module of this package."""
INPUTS = (
    (
        ("files", "recording", "sources", "static", "skeleton", "forces", "marker_set"),
        "there is no such file",
        "check the name and the folder",
    ),
    (
        ("run_folder", "runs", "warm"),
        "there is no such folder",
        "name a run folder, as --out made it",
    ),
)
"""Options that name what is read, and the problem and remedy where it is not there."""
OTHER_WORDS = {
    "scale": "fit` scales the human and solves its motion in one step",
    "ik": "fit` scales the human and solves its motion in one step",
    "id": "fit` also computes forces and joint moments",
    "track": "synthesize track` tracks a recording by a dynamically consistent motion",
    "walk": "synthesize walk` generates a walk, `plantigrade simulate` moves a person by forces",
    "run": "demo` is a first run of everything, `plantigrade --help` lists the commands",
    "export": "convert RUN FILE` writes a run in another format",
}
"""Names of commands in other programs, and ours."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Args:
        arguments: Words after ``plantigrade``; those of the process if absent.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None:  # of a process of its own
        gc.set_threshold(GC_THRESHOLD)
        # Python would search all objects for cycles before it ends: a third of a second
        atexit.register(gc.freeze)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # letters that its encoding lacks are escaped
            stream.reconfigure(errors="backslashreplace")
    try:
        with on_signal(signal.SIGTERM, _terminate):
            code = run(words)
        sys.stdout.flush()  # here, where a closed pipe can still be met
        return code
    except SystemExit as stop:  # the parser has printed its help (0) or its complaint (2)
        return stop.code if isinstance(stop.code, int) else BAD_INPUT
    except PlantigradeError as error:
        code = _complain(f"error: {error}", BAD_INPUT)
        for note in getattr(error, "__notes__", ()):
            print(printable(note), file=sys.stderr)
        return code
    except BrokenPipeError:  # `plantigrade data | head`: the reader has seen enough
        _discard_output()
        return DONE
    except OSError as error:  # no permission, no space, a folder where a file was named
        return _complain(f"error: {_refusal(error)}", BAD_INPUT)
    except _Terminated:
        return _complain(f"terminated: {_KEPT}", TERMINATED)
    except KeyboardInterrupt:
        return _complain(f"interrupted: {_KEPT}", INTERRUPTED)


class _Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does."""


def _terminate(*_: Any) -> None:
    """End as on Ctrl-C: the system asks this process to terminate."""
    raise _Terminated


def usage() -> str:
    """Return the help page of the program."""
    width = max(map(len, COMMANDS))
    listed = "\n".join(f"  {name:{width}}  {what}" for name, what in COMMANDS.items())
    return (
        "usage: plantigrade COMMAND [OPTIONS]\n\n"
        "Physics-based human motion with multi-segment feet.\n\n"
        f"commands:\n{listed}\n\n"
        "`plantigrade COMMAND --help` lists the options of a command;\n"
        "`plantigrade --version` prints the version;\n"
        "`plantigrade --print-completion {bash,zsh,fish}` prints a shell completion script.\n"
        "Start with `plantigrade demo`, then `plantigrade fit FILE`."
    )


def run(words: Sequence[str]) -> int:
    """Do what ``words`` say, print the outcome and return the exit code.

    Raises:
        PlantigradeError: On bad input of any kind.
        SystemExit: If the parser has printed its help or its complaint.
    """
    if not words or words[0] in ("-h", "--help", "help"):
        print(usage())
        return DONE
    if words[0] in ("-V", "--version"):
        print(f"plantigrade {__version__}")
        return DONE
    if words[0] == "--print-completion":
        print(completion(*words[1:2]))
        return DONE
    if words[0] not in COMMANDS:
        raise PlantigradeError(_unknown(words[0]))
    command = parse(words[0], words[1:])
    _refuse_absent(command)
    # Output of libraries while the command runs must not mix with the JSON on standard output.
    with _output_to_errors() if command.json else contextlib.nullcontext():
        outcome = _outcome_of(command)
    if command.json:
        from plantigrade.record.metrics import metrics_json

        if outcome.text:
            print(printable(outcome.text), file=sys.stderr)
        print(metrics_json(outcome.metrics))
    elif outcome.text:
        print(coloured(printable(outcome.text), sys.stdout))
    return DONE if outcome.ok else NO_RESULT


def _outcome_of(command: Any) -> Outcome:
    """Run a command, and print its pages as PDF where that is asked for."""
    if not getattr(command, "pdf", False):
        return command.run()
    from plantigrade.pages.pdf import browser

    browser()  # fails before any computation where no browser is installed
    return command.with_pdf(command.run())


def parse(name: str, words: Sequence[str]) -> Any:
    """Return the settings of command ``name``: the dataclass ``Command`` of its module, filled.

    Raises:
        SystemExit: If the parser has printed its help (code 0) or its complaint (code 2).
        ParameterError: If a value is not allowed.
    """
    from plantigrade.commands import parsing

    module = importlib.import_module(f"plantigrade.commands.{name}")
    with _own_errors():
        if hasattr(module, "parse"):  # a command with subcommands
            return module.parse(words)
        return parsing.parse(module.Command, f"plantigrade {name}", words)


def _refuse_absent(command: Any) -> None:
    """Refuse an input that is not there, before the libraries are loaded that would read it."""
    for names, problem, remedy in INPUTS:
        for name in names:
            value = getattr(command, name, None)
            for path in value if isinstance(value, tuple) else (value,):
                if not isinstance(path, Path) or glob.has_magic(str(path)):
                    continue
                there = True
                with contextlib.suppress(OSError, ValueError):  # its reader says what is wrong
                    there = path.exists()
                if not there:
                    raise FileError(path, problem, remedy=remedy)


@contextlib.contextmanager
def _own_errors() -> Iterator[None]:
    """Raise our own error where the parser would print it in its words."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            yield
    except SystemExit as stop:
        cause: BaseException | None = stop
        while cause is not None and not isinstance(cause, PlantigradeError):
            cause = cause.__context__
        if cause is not None:
            raise cause from None
        raise
    finally:
        if not isinstance(sys.exception(), PlantigradeError):
            sys.stderr.write(printable(said.getvalue()))


def completion(shell: str = "") -> str:
    """Return the script that completes commands, tasks, options and choices in a shell.

    Raises:
        ParameterError: If there is none for that shell.
    """
    from plantigrade.commands import parsing

    every: dict[str, tuple[str, Any]] = {}
    for name, what in COMMANDS.items():
        module = importlib.import_module(f"plantigrade.commands.{name}")
        kinds = getattr(module, "SUBCOMMANDS", None)
        if kinds is not None:
            kinds = {each: ((kind.__doc__ or each).splitlines()[0], kind)
                     for each, kind in kinds.items()}  # fmt: skip
        with contextlib.suppress(CheckoutNeeded):  # no completion for what cannot run
            every[name] = what, kinds or module.Command
    return parsing.completion(shell, every)


def _unknown(name: str) -> str:
    if name.startswith("-"):
        return f"option {name} must come after the command: `plantigrade COMMAND {name}`"
    if name in OTHER_WORDS:
        return f"no command {name!r}: `plantigrade {OTHER_WORDS[name]}"
    hint = did_you_mean(name, COMMANDS)
    return f"no command {name!r}; {hint}there are {', '.join(COMMANDS)}"


def _refusal(error: OSError) -> str:
    """Return what the system refused, of a file as the user knows it: not of its temporary part."""
    if error.filename is None or error.strerror is None:
        return str(error)
    path, _, part = os.fspath(error.filename).partition(os.sep + ".plantigrade-")
    doing = "cannot be written to" if part else "cannot be used"
    return f"{path}: {doing} ({error.strerror}) — choose a folder you can write to"


def _complain(sentence: str, code: int) -> int:
    print(printable(sentence, lines=False), file=sys.stderr)
    return code


@contextlib.contextmanager
def _output_to_errors() -> Iterator[None]:
    """Send standard output to standard error meanwhile, that of compiled libraries too."""
    sys.stdout.flush()
    with contextlib.redirect_stdout(sys.stderr):
        try:
            kept = os.dup(1)
        except OSError:  # the process was started without a standard output
            yield
            return
        try:
            os.dup2(2, 1)
            yield
        finally:
            os.dup2(kept, 1)
            os.close(kept)


def _discard_output() -> None:
    """Point standard output at nothing, so that the interpreter's last flush cannot fail."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
