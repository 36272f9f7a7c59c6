"""Exceptions of the package.

Each message says what was given, what is allowed and what to do. The command line
turns any :class:`PlantigradeError` into one sentence and exit code 2.
"""

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path

from plantigrade.printable import printable

MAX_MESSAGE = 400  #: Maximum length of a message [characters], about three lines of a terminal
MAX_LIST = 240  #: Maximum length of a list of names in a message [characters]


class PlantigradeError(Exception):
    """Base class of all exceptions of the package."""

    def __str__(self) -> str:
        """Return the message itself (``KeyError`` would quote it), of at most 400 characters."""
        return _short(str(self.args[0]), MAX_MESSAGE) if self.args else ""


class ParameterError(PlantigradeError, ValueError):
    """A parameter lies outside what is allowed."""


class FileError(PlantigradeError, ValueError):
    """A file cannot be read or written.

    Attributes:
        path: The file.
        where: Line, field, block or label in the file; empty if it concerns the whole file.
        problem: What was found and what was expected.
        remedy: What to do.
    """

    def __init__(self, path: str | Path, problem: str, *, where: str = "", remedy: str = ""):
        """Build the message from its parts; what a file says is escaped, and shortened if long."""
        where, problem = (
            _short(printable(text, lines=False), most)
            for text, most in ((where, 80), (problem, 250))
        )
        self.path, self.where, self.problem, self.remedy = Path(path), where, problem, remedy
        place = f"{self.path}: {where}" if where else f"{self.path}"
        super().__init__(f"{place}: {problem}" + (f" — {remedy}" if remedy else ""))

    def __reduce__(self):
        """Make the error survive pickling between processes."""
        return (_rebuild_file_error, (type(self), self.path, self.problem, self.where, self.remedy))


def _short(text: str, length: int) -> str:
    """Return a text, shortened in the middle to the given length."""
    half = length // 2
    return text if len(text) <= length else f"{text[: half - 2]} … {text[1 - half :]}"


def not_ordinary(path: str | Path) -> FileError:
    """Return the error of an input that is a pipe or a device: reading it may never end."""
    problem = "is a pipe or a device, not a regular file"
    return FileError(path, problem, remedy="copy its contents to a file and name that")


def _rebuild_file_error(kind, path, problem, where, remedy):
    return kind(path, problem, where=where, remedy=remedy)


class UnsupportedFormat(FileError):
    """The package does not read or write this file format."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a question for the known name that is nearest, or nothing where none is near.

    Example:
        >>> did_you_mean("wlak", ["walk", "squat"]), did_you_mean("xyzzy", ["walk", "squat"])
        ('did you mean walk? ', '')
    """
    near = difflib.get_close_matches(str(name), list(known), n=1)
    return f"did you mean {near[0]}? " if near else ""


def known_names(name: str, known: Sequence[str]) -> str:
    """Return the known names for a message, those most similar to ``name`` first, shortened.

    Example:
        >>> known_names("knee", ["hip_flexion_r", "knee_angle_r", "knee_angle_l"])
        'there are knee_angle_r, knee_angle_l, hip_flexion_r'
    """
    near = difflib.get_close_matches(name, known, n=4, cutoff=0.4)
    listed = [*near, *(each for each in known if each not in near)]
    shown, length = [], 0
    for each in listed:
        length += len(each) + 2
        if length > MAX_LIST:
            break
        shown.append(each)
    more = f" and {len(listed) - len(shown)} more" if len(shown) < len(listed) else ""
    return f"{did_you_mean(name, known)}there are {', '.join(shown)}{more}"


class CoordinateNotFound(PlantigradeError, KeyError):
    """A coordinate, joint or body name does not exist on this Human."""


class FigureNotFound(PlantigradeError, KeyError):
    """A run has no figure of this name."""


class MissingExtra(PlantigradeError, ImportError):
    """An optional library is not installed; the message names the install line."""


class CheckoutNeeded(PlantigradeError):
    """A feature is part of the checkout only, not of the installed package."""


class DownloadError(PlantigradeError, ConnectionError):
    """A public file could not be downloaded; the message says why and what to do."""


class FitError(PlantigradeError, ValueError):
    """A recording cannot be fitted; the message says why and what helps."""


class NothingToFit(FitError):
    """A recording contains no motion, only ground reactions, for example."""


class RunExists(PlantigradeError, FileExistsError):
    """The run folder exists and may not be replaced."""


class SolverError(PlantigradeError, RuntimeError):
    """A solver found no solution; the message names the problem and what to relax."""


class ReproduceError(PlantigradeError, ValueError):
    """A recorded motion cannot be reproduced; the message says why and what helps."""
