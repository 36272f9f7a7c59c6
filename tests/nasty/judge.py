"""Outcomes of a mutant: it is read, or refused by one sentence of our own; else a finding."""

import os
import re
import shutil
import sys
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path

from plantigrade.errors import MAX_MESSAGE, FileError, PlantigradeError
from plantigrade.printable import UNSAFE
from tests.nasty import mutants
from tests.nasty.seeds import Make
from tests.nasty.targets import TARGETS, BadValue, Target

READ, REFUSED = "read", "refused"
FINDINGS = ("foreign exception", "bad message", "bad value", "memory", "hang", "crash", "files")
"""Kinds of findings."""
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]{6,}")
PACKAGE = f"{os.sep}plantigrade{os.sep}"


@dataclass(frozen=True)
class Outcome:
    """Outcome of a mutant.

    Attributes:
        kind: ``"read"``, ``"refused"`` or one of :data:`FINDINGS`.
        where: Exception and place in the package, alike for equal findings.
        said: What was said.
    """

    kind: str
    where: str = ""
    said: str = ""

    @property
    def is_finding(self) -> bool:
        """Whether it should not have happened."""
        return self.kind in FINDINGS


class Damaged:
    """A seed in a folder of its own, whose mutants are read there one after the other."""

    def __init__(
        self,
        target: Target,
        folder: Path,
        make: Make | None = None,
        writes: "Writes | None" = None,
    ):
        """Make the small seed of the target, or another one; listen to what is written."""
        self.target, self.folder = target, folder
        self.writes = None if target.writes else writes
        folder.mkdir(parents=True, exist_ok=True)
        self.path = (make or target.make)(folder)
        self.content = self.path.read_bytes()
        self._files = listing(folder)

    def outcome(self, content: bytes) -> Outcome:
        """Return what becomes of these bytes in place of the seed's."""
        self.path.write_bytes(content)
        if self.writes is None:
            found = outcome(self.target, self.path)
        else:
            with self.writes:
                found = outcome(self.target, self.path)
            if seen := self.writes.seen:
                found = Outcome("files", seen[0], "; ".join(seen[:9]))
        if left := listing(self.folder) ^ self._files:
            for name in left:
                remove(self.folder / name)
            found = Outcome("files", f"{sorted(left)[0]} came or went", f"{sorted(left)[:9]}")
        return found


def findings(name: str, folder: Path, count: int) -> list[str]:
    """Return what is wrong with any of so many mutants of a target, for a test."""
    seed = Damaged(TARGETS[name], folder)
    assert seed.outcome(seed.content).kind == READ  # else nothing else says anything
    tried = mutants(f"test/{name}", seed.content, seed.target.ways, count)
    return [
        f"{what}: {found}" for what, content in tried if (found := seed.outcome(content)).is_finding
    ]


def outcome(target: Target, path: Path) -> Outcome:
    """Return what reading a damaged file ends in."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            target.read(path)
        except BadValue as error:
            return Outcome("bad value", f"{target.name}: {error}", str(error))
        except PlantigradeError as error:
            return _refusal(error, path, target)
        except MemoryError as error:
            return Outcome("memory", place(error), str(error))
        except Exception as error:
            said = f"{type(error).__name__}: {error}"
            return Outcome("foreign exception", f"{type(error).__name__} {place(error)}", said)
    return Outcome(READ)


def _refusal(error: PlantigradeError, path: Path, target: Target) -> Outcome:
    """Return whether an error of our own is one that helps."""
    said, wrong = str(error), ""
    if not said or len(said) > MAX_MESSAGE:
        wrong = f"{len(said)} characters"
    elif "\n" in said or UNSAFE.search(said):
        wrong = "control characters"
    elif ADDRESS.search(said):
        wrong = "address of an object"
    elif isinstance(error, FileError) and path.parent not in (error.path, error.path.parent):
        wrong = "names another file"
    elif isinstance(error, FileError) and not error.remedy and target.has_remedies:
        wrong = "no remedy"
    return Outcome("bad message", f"{wrong}, {place(error)}", said) if wrong else Outcome(REFUSED)


def place(error: BaseException) -> str:
    """Return the innermost place in the package that an error comes from."""
    inside = [f for f in traceback.extract_tb(error.__traceback__) if PACKAGE in f.filename]
    if not inside:
        return "outside of the package"
    last = inside[-1]
    return f"{last.filename.rpartition(PACKAGE)[2]}:{last.lineno} {last.name}"


def listing(folder: Path) -> set[str]:
    """Return the names of everything in a folder and the folders in it."""
    return {
        os.path.relpath(os.path.join(where, name), folder)
        for where, folders, files in os.walk(folder)
        for name in (*folders, *files)
    }


def remove(path: Path) -> None:
    """Remove a file or a folder, where it is still there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


class Writes:
    """Tells of every file written, process started and connection made while it is watched.

    A hook of the interpreter cannot be removed: it is for processes that do nothing else.
    """

    ACTS = ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.chmod",
            "os.system", "os.exec", "subprocess.Popen", "socket.connect", "shutil.rmtree",
            "pickle.find_class", "exec_script")  # fmt: skip

    def __init__(self) -> None:
        """Begin to listen, not yet to tell."""
        self.watched = False
        self.seen: list[str] = []
        sys.addaudithook(self._hear)

    def __enter__(self) -> None:
        """Begin to tell."""
        self.watched, self.seen = True, []

    def __exit__(self, *_: object) -> None:
        """Tell no more."""
        self.watched = False

    def _hear(self, event: str, arguments: tuple) -> None:
        if not self.watched:
            return
        if event in self.ACTS:
            self.seen.append(f"{event} {arguments[:1]}")
        elif event == "open" and isinstance(arguments[2], int):
            if arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC):
                self.seen.append(f"open {arguments[0]} to write")
