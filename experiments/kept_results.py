"""Results of a long experiment, kept in a file so that it can be stopped and taken up again."""

import hashlib
import json
import math
import os
import platform
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import plantigrade
from plantigrade.errors import FileError
from plantigrade.record.jobs import run_jobs

Result = dict[str, Any]
DRAWN = {"charts", "commands", "live", "pages"}
"""Rooms of the package that show results and decide none."""
READ = {".py", ".toml", ".json", ".npz"}
"""Endings of files that decide results: code, and what it reads from the package (policies)."""


class KeptResults:
    """Results by key: found in a file (JSON; none: not kept), or made and written there at once.

    ``say`` is called with one line per result that is made; ``anew`` forgets what is in the file.
    """

    def __init__(
        self,
        path: Path | None = None,
        say: Callable[[str], None] = lambda _: None,
        *,
        anew: bool = False,
    ):
        self.path, self.say = path, say
        self.results: dict[str, Result] = {}
        if path is not None and path.exists() and not anew:
            try:
                held = json.loads(path.read_text(encoding="utf-8"))
                self.results = {str(k): dict(v) for k, v in held.items()}
            except (OSError, ValueError, AttributeError, TypeError, RecursionError) as error:
                raise FileError(
                    path, f"holds no results ({error})", remedy="delete it to start again"
                ) from error

    def get(
        self,
        key: str,
        make: Callable[[], Mapping[str, Any]],
        brief: Callable[[Result], str] = lambda _: "made",
    ) -> Result:
        """Return the result of a key, made if it is not there; ``brief`` says how that went.

        What ``make`` returns must be plain: numbers, words, lists, dictionaries.
        """
        if key not in self.results:
            self.results[key] = {**_plain(make()), "code": code_version()}
            self._write()
            self.say(f"{key}: {brief(self.results[key])}")
        return self.results[key]

    def get_all(
        self,
        cases: Mapping[str, Callable[[], Mapping[str, Any]]],
        brief: Callable[[Result], str] = lambda _: "made",
        *,
        jobs: int = 1,
    ) -> dict[str, Result]:
        """Return the results of many keys; those not there are made, several at once.

        Each is kept as soon as it is there. What fails is a result, too: its ``error``.
        """
        missing = [key for key in cases if key not in self.results]
        work = _Making({key: cases[key] for key in missing})
        for done in run_jobs(work, missing, jobs=jobs):
            found = {"error": done.problem} if done.result is None else done.result
            self.get(done.item, lambda found=found: found, brief)
        return {key: self.results[key] for key in cases}

    def beginning(self, prefix: str) -> dict[str, Result]:
        """Return the results whose keys begin so, in the order they were made."""
        return {k: v for k, v in self.results.items() if k.startswith(prefix)}

    def notes(self) -> list[str]:
        """Return a sentence about results of earlier code, if there are any."""
        old = sum(r.get("code") != code_version() for r in self.results.values())
        which = f"{old} of {len(self.results)} results in {self.path}"
        words = f"{which} were made by other code than today's; --overwrite measures all anew."
        return [words] if old else []

    def provenance(self) -> dict[str, Any]:
        """Return where the results come from, for a page."""
        return {
            "plantigrade": plantigrade.__version__,
            "code": code_version(),
            "results": len(self.results),
            "processor": f"{platform.machine()}, {os.cpu_count()} cores",
            "python": platform.python_version(),
        }

    def _write(self) -> None:
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        part = self.path.with_suffix(".part")
        part.write_text(json.dumps(self.results, indent=1), encoding="utf-8")
        part.replace(self.path)


class _Making:
    """Makes results by key, in any process."""

    def __init__(self, cases: Mapping[str, Callable[[], Mapping[str, Any]]]):
        self.cases = dict(cases)

    def __call__(self, key: str) -> Mapping[str, Any]:
        return self.cases[key]()


@cache
def code_version() -> str:
    """Return a word that changes with the code of the experiments and of the package.

    What they read from the package, as scripts of motions, belongs to it.
    """
    experiments = Path(__file__).parent
    package = Path(plantigrade.__file__).parent
    files = [path for path in package.rglob("*")
             if path.relative_to(package).parts[0] not in DRAWN]  # fmt: skip
    digest = hashlib.sha256()
    for path in sorted([*experiments.rglob("*"), *files]):
        if path.suffix in READ:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _plain(value: Any) -> Any:
    """Return a value as JSON holds it; what is no number becomes None."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
