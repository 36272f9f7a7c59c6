"""Pages whose commands are pasted one after the other, in the order of the page, into a folder."""

import json
import re
import shlex
import shutil
from collections.abc import Iterator
from dataclasses import fields
from glob import glob
from pathlib import Path

from plantigrade.commands import main as cli

INPUTS = (
    *("files", "run_folder", "source", "sources", "recording", "warm", "static", "skeleton"),
    *("forces", "marker_set", "folder", "file"),
)
"""Options and words of commands that name what must be there."""


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)


def commands(page: Path, language: str = "bash") -> Iterator[list[str]]:
    """Return the words of each command of a page, patterns of files not yet replaced."""
    for block in blocks(page, language):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if words:
                yield words


def paste(page: Path, run: set[str]) -> list[str]:
    """Paste the commands of a page into the folder one is in; return the names of those that ran.

    Commands of plantigrade in ``run`` run, the other ones are parsed: their options must be
    valid, and the files they name must be there; what they would make is put there as an empty
    run. What is downloaded is only parsed, and what is in other languages than bash is left out.
    """
    ran = []
    for given in commands(page):
        said = given.index(">") if ">" in given else None
        words, target = given[:said], given[-1] if said is not None else None
        words = [each for word in words for each in (sorted(glob(word)) or [word])]
        if words[0] == "plantigrade" and words[1].startswith("-"):
            assert cli.main(words[1:]) == 0
        elif words[0] == "plantigrade":
            parsed = cli.parse(words[1], words[2:])
            if words[1:3] == ["data", "get"]:  # no test leaves this machine
                continue
            if words[1] in run:
                assert cli.main([*words[1:], "--quiet"]) == 0, words
                ran.append(words[1])
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
        if each.name in INPUTS and value is not None:
            for path in value if isinstance(value, tuple) else (value,):
                assert Path(path).exists(), f"{path} is not there for {shlex.join(words)}"


def _pretend(parsed, command: str) -> None:
    """Make the run folder of a command that is not run."""
    name = getattr(parsed, "name", None)
    if command in ("synthesize", "fit", "reproduce"):
        stem = name or parsed.files[0].stem
        folder = parsed.out or Path("runs") / f"{command}-{stem}"
        assert parsed.out is None or parsed.overwrite or not folder.exists(), folder
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "metrics.json").write_text(json.dumps({"format": 2}))
