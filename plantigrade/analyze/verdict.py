"""The verdict of the check: the worst value of every quantity, and a sentence for every fault."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.quantities import OF_COORDINATES, OF_JOINTS, QUANTITY, quantity
from plantigrade.arrays import Array, Float

MAX_STATUS_SENTENCES = 3
"""Maximum number of sentences in :attr:`Verdict.status`; further ones are counted."""


@dataclass(frozen=True)
class Measure:
    """The worst value of one quantity over the motion."""

    #: One of :data:`~plantigrade.analyze.quantities.QUANTITIES` or ``"condition"``
    quantity: str
    value: float  #: The worst value; NaN if there was none
    limit: float  #: The limit
    unit: str  #: Unit of both
    time: float = np.nan  #: Time of the worst value [s]; NaN for a mean over the motion
    name: str = ""  #: Site, coordinate or condition; empty for the whole body
    side: str = ""  #: ``"r"``, ``"l"`` or empty
    bad: bool = False  #: Whether the limit is exceeded by more than the tolerance
    below: bool = False  #: Whether the limit is a lower one


@dataclass(frozen=True)
class Finding(Measure):
    """One fault, with place and time of its worst value."""

    start: float = np.nan  #: Start of the violation [s]
    end: float = np.nan  #: End of the violation [s]
    #: More sites of the same foot with the same fault at the same time
    others: tuple[str, ...] = ()
    #: Value over limit, or violation over tolerance for a condition
    excess: float = np.nan
    advice: str = ""  #: Advice; that of the quantity if empty

    @property
    def where(self) -> str:
        """Readable location, such as ``"left heel back medial"``, or the name of a coordinate."""
        if self.quantity in (*OF_COORDINATES, "pressure"):
            return self.name
        plain = self.name.removesuffix(f"_{self.side}") if self.side else self.name
        return ({"r": "right ", "l": "left "}.get(self.side, "") + plain).replace("_", " ")

    def sentence(self, more_times: int = 0) -> str:
        """Return a sentence with fault, location, time, limit and advice.

        Args:
            more_times: Number of further occurrences.
        """
        kind = quantity(self.quantity)
        if np.isnan(self.value):
            return f"{self.where} could not be checked: the motion has no frames at its times"
        what = kind.words.format(where=self.where, value=_number(self.value), unit=self.unit)
        bound = "at least" if self.below else "at most"
        allowed = f"{bound} {_number(self.limit)} {self.unit}".rstrip()
        if self.others:
            n, foot = len(self.others), self.side and self.quantity not in OF_COORDINATES
            more = ("more place" if n == 1 else "more places") + " of that foot" if foot else "more"
            what += f" (as {'does' if n == 1 else 'do'} {n} {more})"
        again = "once more" if more_times == 1 else f"{more_times} more times"
        when = self._when() + (f", and {again}" if more_times else "")
        return f"{what} {when}; {allowed} is allowed: {self.advice or kind.advice}"

    def _when(self) -> str:
        if np.isnan(self.time):
            return "over the whole motion"
        if self.end - self.start < 5e-3:
            return f"at {self.time:.2f} s"
        return f"between {self.start:.2f} and {self.end:.2f} s"


@dataclass(frozen=True, eq=False)
class Slip:
    """One stance of one site."""

    site: str  #: Name of the site
    side: str  #: Side of its foot
    start: float  #: Time of the first frame of the stance [s]
    end: float  #: Time of the last frame [s]
    distance: float  #: Largest tangential displacement since touchdown [mm]
    time: float  #: Time of that displacement [s]
    since: float  #: Time at 5 % of that displacement [s]
    until: float  #: Time at 95 % of that displacement [s]


@dataclass(frozen=True, eq=False)
class Verdict:
    """The verdict of the check on a Record."""

    measures: dict[str, Measure]  #: The worst value of every quantity by name
    conditions: dict[str, Measure]  #: The worst value of every condition of the task by name
    findings: tuple[Finding, ...]  #: Faults, worst first
    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    #: Generalised forces from inverse dynamics [N m]; the first six entries are the residual at
    #: the root (world force [N], moment about the pelvis in body axes [N m])
    tau: Float[Array, "n_frames nv"]
    root_force: Float[Array, "n_frames 3"]  #: Residual force, world [N]
    #: Residual moment about the centre of mass, world [N m]
    root_moment: Float[Array, "n_frames 3"]
    com: Float[Array, "n_frames 3"]  #: Centre of mass [m]
    contact_point: Float[Array, "n_frames n_sites 3"]  #: Lowest point of each site, world [m]
    gap: Float[Array, "n_frames n_sites"]  #: Height of that point above its support [m]
    #: Centre of pressure that the motion requires, world [m]; NaN without a significant force
    centre_of_pressure: Float[Array, "n_frames 3"]
    slips: tuple[Slip, ...]  #: Every stance of every site

    @property
    def ok(self) -> bool:
        """Whether there are no faults."""
        return not self.findings

    @property
    def status(self) -> str:
        """``"ok"``, or the worst faults with location and time."""
        words = self.sentences()
        if self.ok:
            return "ok"
        more = len(words) - MAX_STATUS_SENTENCES
        if more > 0:
            words = [
                *words[:MAX_STATUS_SENTENCES],
                f"and {more} more finding{'s' if more > 1 else ''}",
            ]
        return "; ".join(words)

    def sentences(self) -> list[str]:
        """Return one sentence for each fault; a recurring fault is reported at its worst time."""
        if self.ok:
            return [f"checked {len(self.time)} frames: everything is within its limits"]
        times: dict[tuple[str, str], list[Finding]] = {}
        for finding in self.findings:
            where = finding.name if finding.quantity in OF_JOINTS else finding.side or finding.name
            times.setdefault((finding.quantity, where), []).append(finding)
        return [
            max(same, key=lambda f: f.excess).sentence(len(same) - 1) for same in times.values()
        ]

    def figures(self) -> dict[str, Any]:
        """Return flat figures for ``metrics.json``, unit as suffix."""
        figures: dict[str, Any] = {
            "check_ok": self.ok,
            "check_frames": len(self.time),
            "check_findings": len(self.findings),
        }
        figures |= {QUANTITY[q].key: measure.value for q, measure in self.measures.items()}
        if self.conditions:
            figures["check_conditions"] = len(self.conditions)
            figures["check_conditions_broken"] = sum(m.bad for m in self.conditions.values())
        return figures

    def signals(self) -> dict[str, np.ndarray]:
        """Return all measures and findings as signals of a Record, conditions last."""
        rows = [*self.measures.values(), *self.conditions.values()]

        def words(values: list[str]) -> np.ndarray:
            return np.array(values, dtype=np.str_) if values else np.array([], dtype="U1")

        return {
            "check.quantity": words([m.quantity for m in rows]),
            "check.value": np.array([m.value for m in rows], float),
            "check.limit": np.array([m.limit for m in rows], float),
            "check.time": np.array([m.time for m in rows], float),
            "check.where": words([m.name + (" (at least)" if m.below else "") for m in rows]),
            "check.side": words([m.side for m in rows]),
            "check.unit": words([m.unit for m in rows]),
            "check.bad": np.array([m.bad for m in rows], bool),
            "check.findings": words([f.sentence() for f in self.findings]),
        }

    def __repr__(self) -> str:
        return f"Verdict({len(self.time)} frames, {self.status})"


def _number(value: float) -> str:
    """Return a number with three significant digits."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
