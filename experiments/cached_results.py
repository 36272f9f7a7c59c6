"""Cached results of a long experiment: a JSON file, so that an interrupted run can continue."""

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
Cases = Mapping[str, Callable[[], Mapping[str, Any]]]
"""Key of a result → function that computes it."""
DISPLAY = {"charts", "commands", "live", "pages"}
"""Rooms of the package that display results and decide none."""
CODE_SUFFIXES = {".py", ".toml", ".json", ".npz"}
"""Suffixes of files that decide results: code, and the data of the package (policies)."""


class CachedResults:
    """Results by key, read from a JSON file, or computed and written to it at once.

    Keys are names joined by slashes. Without a path, results are kept in memory alone.

    Args:
        path: The file.
        say: Called with one line for each computed result.
        overwrite: Whether the results in the file are discarded.

    Raises:
        FileError: If the file does not hold results.
    """

    def __init__(
        self,
        path: Path | None = None,
        say: Callable[[str], None] = lambda _: None,
        *,
        overwrite: bool = False,
    ):
        self.path, self.say = path, say
        self.results: dict[str, Result] = {}
        if path is not None and path.exists() and not overwrite:
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
        compute: Callable[[], Mapping[str, Any]],
        summary: Callable[[Result], str] = lambda _: "computed",
    ) -> Result:
        """Return the result of a key, computed if it is not there.

        Args:
            key: Its key.
            compute: Returns it: numbers, strings, lists and dictionaries.
            summary: Returns one line about it.
        """
        if key not in self.results:
            self.results[key] = {**_plain(compute()), "code": code_version()}
            self._write()
            self.say(f"{key}: {summary(self.results[key])}")
        return self.results[key]

    def get_all(
        self,
        cases: Cases,
        summary: Callable[[Result], str] = lambda _: "computed",
        *,
        jobs: int = 1,
    ) -> dict[str, Result]:
        """Return the results of many keys; missing ones are computed, ``jobs`` at once.

        Each is written as soon as it is there. A case that fails has its ``error`` as result.
        """
        missing = [key for key in cases if key not in self.results]
        work = _Computation({key: cases[key] for key in missing})
        for done in run_jobs(work, missing, jobs=jobs):
            found = {"error": done.problem} if done.result is None else done.result
            self.get(done.item, lambda found=found: found, summary)
        return {key: self.results[key] for key in cases}

    def select(self, *names: object, failed: bool = False) -> dict[str, Result]:
        """Return the results whose keys begin with these names, in the order of computation.

        Args:
            names: First parts of the key.
            failed: Whether results with an error are included.
        """
        prefix = "/".join(map(str, names))
        return {
            key: result
            for key, result in self.results.items()
            if (not names or key == prefix or key.startswith(f"{prefix}/"))
            and (failed or "error" not in result)
        }

    def longest(self, *names: object, failed: bool = False) -> dict[str, Result]:
        """Return the results of :meth:`select` by key without its last part, a duration (``9 s``).

        Of what was done for a short and for a long time, the long one counts.
        """
        found: dict[str, tuple[float, Result]] = {}
        for key, result in self.select(*names, failed=failed).items():
            what, _, duration = key.rpartition("/")
            seconds = float(duration.removesuffix(" s"))
            if what not in found or seconds > found[what][0]:
                found[what] = seconds, result
        return {what: result for what, (_, result) in found.items()}

    def notes(self) -> list[str]:
        """Return a sentence about results of earlier code, if there are any."""
        old = sum(r.get("code") != code_version() for r in self.results.values())
        which = f"{old} of {len(self.results)} results in {self.path}"
        note = f"{which} are of an earlier version of the code; --overwrite measures again."
        return [note] if old else []

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


class _Computation:
    """Computes results by key, in any process."""

    def __init__(self, cases: Cases):
        self.cases = dict(cases)

    def __call__(self, key: str) -> Mapping[str, Any]:
        return self.cases[key]()


@cache
def code_version() -> str:
    """Return a hash of the code of the experiments and the package, and of the package's data."""
    package = Path(plantigrade.__file__).parent
    files = [*Path(__file__).parent.rglob("*")]
    files += [p for p in package.rglob("*") if p.relative_to(package).parts[0] not in DISPLAY]
    digest = hashlib.sha256()
    for path in sorted(p for p in files if p.suffix in CODE_SUFFIXES):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _plain(value: Any) -> Any:
    """Return a value as JSON holds it; numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
