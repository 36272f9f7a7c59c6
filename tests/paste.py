"""Documentation pages whose commands are executed in order in a folder."""

import json
import re
import shlex
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from glob import glob
from pathlib import Path
from typing import Any

from plantigrade.commands import main as cli

INPUTS = (
    *("files", "run_folder", "source", "sources", "recording", "warm", "static", "skeleton"),
    *("forces", "marker_set", "folder", "file", "runs"),
)
"""Options and arguments that name required files."""
Call = Callable[[list[str]], str]
NUMBER = re.compile(r"[-−+]?\d[\d.,]*(e[-+]?\d+)?")


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)


def run_code(page: Path) -> dict[str, Any]:
    """Return every name that a page defines, after all its Python has run from top to bottom."""
    names: dict[str, Any] = {"__name__": "page"}
    for block in blocks(page, "python"):
        exec(compile(block, str(page), "exec"), names)
    return names


def commands(page: Path, *languages: str) -> Iterator[list[str]]:
    """Return the words of each command of a page, patterns of files not yet replaced.

    Of a console only the lines after ``$`` are commands.
    """
    for words, _ in _pasted(page, languages or ("bash", "console")):
        yield words


def _pasted(page: Path, languages: tuple[str, ...]) -> Iterator[tuple[list[str], str | None]]:
    """Yield the words of each command, and its output on the page."""
    fences = rf"^```({'|'.join(languages)})\n(.*?)^```"
    for language, block in re.findall(fences, page.read_text("utf-8"), re.M | re.S):
        if language == "console":
            for each in re.split(r"^\$ ", block, flags=re.M)[1:]:
                line, _, printed = each.partition("\n")
                yield shlex.split(line), printed
            continue
        for line in block.replace("\\\n", " ").splitlines():
            if language == "bash" or line.startswith("plantigrade "):
                words = shlex.split(line, comments=True)
                if words:
                    yield words, None


def inline_commands(page: Path) -> Iterator[list[str]]:
    """Return the words of each command inside the sentences and tables of a page.

    The name of a command alone is none.
    """
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.M | re.S)
    for line in re.findall(r"`(plantigrade [a-z]+ [^`]+)`", text):
        if not re.search(r"\b[A-Z]{3,}\b|…", line):  # FILE, NAME, COMMAND stand for something
            yield shlex.split(line)


def paste(page: Path, run: set[str], call: Call, also: Sequence[str] = ()) -> list[str]:
    """Paste the commands of a page into the folder one is in; return those that ran.

    A command in ``run`` runs where the page shows what it prints, and so do the lines in ``also``.
    The other ones are parsed: their options must be valid, and the files they name must be there;
    what they would make is put there as an empty run. What is downloaded is only parsed, and
    blocks in other languages are left out.

    Args:
        page: The page.
        run: Names of commands.
        call: Runs the words after ``plantigrade`` and returns what they print.
        also: Whole commands, as the page has them.
    """
    ran = []
    for given, shown in _pasted(page, ("bash", "console")):
        line = " ".join(given)
        said = given.index(">") if ">" in given else None
        words, target = given[:said], given[-1] if said is not None else None
        words = [each for word in words for each in (sorted(glob(word)) or [word])]
        if words[0] == "plantigrade" and words[1].startswith("-"):
            call(words[1:])
        elif words[0] == "plantigrade":
            parsed = cli.parse(words[1], words[2:])
            if words[1:3] == ["data", "get"]:  # no test leaves this machine
                continue
            if line in also or (shown is not None and words[1] in run):
                printed = call(words[1:])
                ran.append(line)
                assert shown is None or fits(printed, shown), f"{page.name}: {line}\n{printed}"
            else:
                _needs(parsed, words)
                _pretend(parsed, words[1])
        elif words[0] in ("cp", "mkdir", "printf"):
            _shell(words, target)
            continue
        if target is not None:
            Path(target).expanduser().parent.mkdir(parents=True, exist_ok=True)
            Path(target).expanduser().touch()
    return ran


def fits(printed: str, shown: str) -> bool:
    """Return whether a text has the form that a page shows: its lines, whatever the numbers.

    A line ``…`` of the page stands for any others; what follows it is not compared.

    Example:
        >>> fits("5 of  2.1 s\\nmore\\n", "1 of 1.0 s\\n…\\n")
        True
    """
    here, there = (
        [NUMBER.sub("#", " ".join(line.split())) for line in text.strip().splitlines()]
        for text in (printed, shown)
    )
    if "…" in there:
        there = there[: there.index("…")]
        here = here[: len(there)]
    return here == there


def _shell(words: list[str], target: str | None) -> None:
    name, *words = (word for word in words if word != "-p")
    paths = [Path(word).expanduser() for word in words]
    if name == "mkdir":
        for path in paths:
            path.mkdir(parents=True, exist_ok=True)
    elif name == "cp":
        shutil.copy(*paths)
    elif target is not None:
        Path(target).write_text(words[0].replace("\\n", "\n"))


def _needs(parsed, words: list[str]) -> None:
    for each in fields(parsed):
        value = getattr(parsed, each.name)
        if each.name in INPUTS and not isinstance(value, bool | None):
            for path in value if isinstance(value, tuple) else (value,):
                assert Path(path).exists(), f"{path} is not there for {shlex.join(words)}"


def _pretend(parsed, command: str) -> None:
    """Make the run folder of a command that is skipped."""
    name = getattr(parsed, "name", None)
    if command in ("synthesize", "fit", "reproduce"):
        stem = name or parsed.files[0].stem
        folder = parsed.out or Path("runs") / f"{command}-{stem}"
        assert parsed.out is None or parsed.overwrite or not folder.exists(), folder
        if folder.exists():  # the command would number its folder
            return
        folder.mkdir(parents=True)
        (folder / "metrics.json").write_text(json.dumps({"format": 2}))
