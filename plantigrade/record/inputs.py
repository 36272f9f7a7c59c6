"""Files, folders, patterns and lists that a user names, as the files they stand for."""

import glob
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from plantigrade.errors import FileError, ParameterError
from plantigrade.io.text import read_text
from plantigrade.options import as_path
from plantigrade.record.metrics import METRICS

LIST_LIMIT = 200e6  # Largest list that is read [bytes]: a million paths


@dataclass(frozen=True)
class Inputs:
    """Files, each once."""

    #: The files, in the order in which they were named; those of a folder by name
    files: tuple[Path, ...]
    #: Those that were named themselves. One of them that holds nothing is an error; one that was
    #: only found in a folder is left out.
    named: frozenset[Path]
    several: bool  #: Whether folders, patterns, a list or more than one file were given
    #: What they are called together: the folder or list, or the first file and their number
    #: (``walk-and-2-more``)
    title: str


def inputs(
    given: Iterable[str | Path],
    *,
    fits: Callable[[Path], bool],
    what: str = "recording",
    listed: str | Path | None = None,
) -> Inputs:
    """Return the files that words stand for.

    Args:
        given: Files, folders (searched with their subfolders; runs in them are passed over), or
            patterns such as ``data/*/walk*.c3d``.
        fits: Whether a file that was found in a folder is of a kind that is looked for.
        what: What is looked for, in messages.
        listed: A text file with one of these words a line; ``#`` begins a comment.

    Raises:
        ParameterError: If nothing is given, a file is named twice, or a folder or pattern holds no
            such file.
        FileError: If the list cannot be read.
    """
    given = [as_path(word, f"a {what}") for word in given]
    words = list(given)
    if listed is not None:
        lines = (line.strip() for line in read_text(listed, LIST_LIMIT).splitlines())
        words += [Path(line) for line in lines if line and not line.startswith("#")]
    if not words:
        raise ParameterError(f"no {what} given: name files, folders, patterns, or a --list of them")
    files: dict[Path, Path] = {}
    named: set[Path] = set()
    once: set[Path] = set()
    several = len(words) > 1 or listed is not None
    for word in words:
        found = _expanded(word, fits)
        if found is None:
            if word.absolute() in once:
                raise ParameterError(f"{word} is given twice; give each {what} once")
            once.add(word.absolute())
            named.add(word)
            files[word.absolute()] = word
            continue
        several = True
        if not found:
            raise ParameterError(f"{word} holds no {what} of a known format")
        for path in found:
            files.setdefault(path.absolute(), path)
    paths = list(files.values())
    title = paths[0].stem + (f"-and-{len(paths) - 1}-more" if len(paths) > 1 else "")
    if len(words) == 1 and words[0].is_dir():
        title = words[0].resolve().name
    elif listed is not None and len(given) == 0:
        title = Path(listed).stem
    return Inputs(tuple(paths), frozenset(named), several, title)


def _expanded(word: Path, fits: Callable[[Path], bool]) -> list[Path] | None:
    """Return the files of a folder or pattern; None for a file."""
    if "\0" in str(word):
        raise ParameterError(f"{str(word)[:40]!r} is not the name of a file")
    if word.is_dir():
        return sorted(path for path in word.rglob("*") if path.is_file() and _counts(path, fits))
    if not word.exists() and glob.has_magic(str(word)):
        found = sorted(map(Path, glob.glob(str(word), recursive=True)))
        inside = [_expanded(path, fits) or [path] if path.is_dir() else [path] for path in found]
        return [path for paths in inside for path in paths]
    return None


def _counts(path: Path, fits: Callable[[Path], bool]) -> bool:
    """Return whether a file of a folder counts: of the kind, and no part of a run."""
    if (path.parent / METRICS).exists():
        return False
    try:
        return fits(path)
    except (FileError, OSError):
        return False


def names_of(files: Sequence[Path]) -> list[str]:
    """Return one name for each file: its own, with its ending or folder where names are alike.

    Example:
        >>> names_of([Path("a/walk.c3d"), Path("a/walk.trc"), Path("b/run.c3d")])
        ['walk-c3d', 'walk-trc', 'run']
    """
    paths = [path.absolute() for path in files]
    names = [path.stem for path in paths]
    longer = (
        lambda p: f"{p.stem}-{p.suffix[1:]}",
        lambda p: f"{p.parent.name}-{p.stem}-{p.suffix[1:]}",
        lambda p: "-".join((*p.parts[1:-1], p.stem, p.suffix[1:])),
    )
    for name_of in longer:
        counts: dict[str, int] = {}
        for name in names:
            counts[name] = counts.get(name, 0) + 1
        names = [name_of(p) if counts[n] > 1 else n for p, n in zip(paths, names, strict=True)]
    return names
