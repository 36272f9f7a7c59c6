"""Notes to the user: warnings, except those marked as information."""

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

_NUMBER = r"\d+(?:[.,]\d+)*"
_SPAN = rf"{_NUMBER} to {_NUMBER} s"
_NUMBERS = re.compile(  # "2.78 to 3.50 s, 3.92 to 4.63 s and 2 times more", or a number
    rf"{_SPAN}(?:, {_SPAN})*(?: and (?:once|\d+ times) more)?|{_NUMBER}"
)


class Info(str):
    """A note of information; any other note is a warning.

    It is a string, so one list holds notes of both kinds.

    Example:
        >>> [note for note in ("no plate was hit", Info("1.30 m/s")) if not isinstance(note, Info)]
        ['no plate was hit']
    """

    __slots__ = ()
    informs = True


class Repeated(NamedTuple):
    """A warning that several results have, with other numbers perhaps."""

    sentence: str  #: The warning; where its numbers differ, ``…`` in their place
    names: tuple[str, ...]  #: Names of the results


def repeated(warnings: Iterable[tuple[str, Sequence[str]]]) -> list[Repeated]:
    """Return each warning once, with the results that have it, the most frequent first.

    Example:
        >>> found = repeated([("a", ["no arms"]), ("b", ["1 frame is lost", "no arms"])])
        >>> [(each.sentence, len(each.names)) for each in found]
        [('no arms', 2), ('1 frame is lost', 1)]
    """
    kinds: dict[str, dict[str, dict[str, None]]] = {}
    for name, sentences in warnings:
        for sentence in sentences:
            kind = kinds.setdefault(_NUMBERS.sub("…", sentence), {})
            kind.setdefault(sentence, {})[name] = None
    found = []
    for kind, sentences in kinds.items():
        names = dict.fromkeys(name for those in sentences.values() for name in those)
        found.append(Repeated(kind if len(sentences) > 1 else next(iter(sentences)), (*names,)))
    return sorted(found, key=lambda each: -len(each.names))
