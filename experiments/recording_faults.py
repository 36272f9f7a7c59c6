"""Hidden faults of recordings: which are refused, named, warned of, or silent.

Every recording with markers of a folder is fitted as it is and with one fault at a time. A sound
one should have none of the first warnings. The people of
:data:`experiments.fit_accuracy.SETTLING_PEOPLE` and of :data:`SETTLING_PEOPLE` set the limits of
the checks; the others are the validation set.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults
from experiments.fit_accuracy import SETTLING_PEOPLE as SETTLED_BEFORE
from experiments.specification import Cases, Specification
from experiments.table import Grid, ResultTable, Row, at_least, equal
from plantigrade.analyze.frame_rate import flight_acceleration
from plantigrade.analyze.plausibility import Plausibility
from plantigrade.analyze.trial import Trial, analyse
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import PlantigradeError
from plantigrade.kinematics.state import body_paths
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import landmarks_of
from plantigrade.motion import Recording
from plantigrade.notes import Info
from plantigrade.workflows.fit import fit_recording, load, status
from plantigrade.workflows.settings import FitSettings

SETTLING_PEOPLE = (*SETTLED_BEFORE, "HC002", "HC030", "HC031", "HC033", "HC036", "Motion-FlatFoot")
"""People on whose recordings limits of the checks were settled, as parts of the names of files."""
NUMBERS = re.compile(r"[-+]?\d+(?:\.\d+)?")
OUTCOMES = ("refused", "named", "warned", "silent")
RANKS = {name: i for i, name in enumerate(OUTCOMES)}

Faulty = Callable[[Recording, Trial], Recording | None]
"""Returns a recording with a fault; None where it cannot have that one."""


@dataclass(frozen=True)
class Fault:
    """A fault of a recording."""

    make: Faulty  #: Makes it
    cause: str  #: Expression that a warning which names the cause matches


def clock(factor: float, *, motion: bool = True, plates: bool = True) -> Faulty:
    """Return the fault of clocks that run slowly by a factor, so that all takes longer."""

    def make(recording: Recording, trial: Trial) -> Recording | None:
        if (plates and not motion and not recording.plates) or recording.markers is None:
            return None
        if not trial.motion.events and flight_acceleration(trial) is None:
            return None  # nothing that people do at rest or in squats has a pace of its own
        start = recording.markers.time[0]
        slow = lambda time: start + factor * (time - start)  # noqa: E731
        found = recording
        if motion:
            marks = replace(recording.markers, time=slow(recording.markers.time))
            events = tuple(replace(e, time=float(slow(e.time))) for e in recording.events)
            found = replace(found, markers=marks, events=events)
        if plates:
            held = tuple(replace(plate, time=slow(plate.time)) for plate in found.plates)
            found = replace(found, plates=held)
        return found

    return make


def without_plates(make: Faulty) -> Faulty:
    """Return a fault of a recording whose plates are lost."""

    def made(recording: Recording, trial: Trial) -> Recording | None:
        found = make(recording, trial)
        if found is None or not recording.plates:
            return None
        return replace(found, plates=())

    return made


def sway(shift: float, turn: float, frequency: float) -> Faulty:
    """Return a laboratory that sways by a length [m] and an angle [deg]; plates do not."""

    def make(recording: Recording, trial: Trial) -> Recording | None:
        del trial
        markers = recording.markers
        assert markers is not None
        wave = np.sin(2 * np.pi * frequency * (markers.time - markers.time[0]))
        angle = np.deg2rad(turn) * wave
        about = np.nanmean(markers.positions, axis=(0, 1)) * [1, 1, 0]
        arm = markers.positions - about
        x = arm[..., 0] * np.cos(angle)[:, None] + arm[..., 2] * np.sin(angle)[:, None]
        z = arm[..., 2] * np.cos(angle)[:, None] - arm[..., 0] * np.sin(angle)[:, None]
        swayed = np.stack([x + shift * wave[:, None], arm[..., 1], z], axis=-1) + about
        return replace(recording, markers=replace(markers, positions=swayed))

    return make


def forces_times(factor: float) -> Faulty:
    """Return forces in another scale, in a file that states no body mass."""

    def make(recording: Recording, trial: Trial) -> Recording | None:
        if trial.forces is None or trial.weighed is None:
            return None
        return _of_mass(_scaled(recording, lambda time: np.full(len(time), factor)), None)

    return make


def cane(share: float, *, stated: bool = True) -> Faulty:
    """Return a hand on a cane that carries a share of the weight while the left foot stands alone.

    ``stated`` is whether the file states the body mass.
    """

    def make(recording: Recording, trial: Trial) -> Recording | None:
        if trial.forces is None or trial.weighed is None or not trial.motion.events:
            return None
        load = trial.forces.force[..., 2] / (trial.weighed.mass * GRAVITY)
        if not (load[:, 1] > 0.5).any():
            return None
        left = np.clip(load[:, 1], 0, None) / np.maximum(load.sum(axis=1), 0.1)

        def factor(time: Float[Array, " n"]) -> Float[Array, " n"]:
            return 1 - share * np.interp(time, trial.fit.time, left)

        return _of_mass(_scaled(recording, factor), trial.weighed.mass if stated else None)

    return make


def handrail(share: float) -> Faulty:
    """Return a rail that carries a share of the weight all the time, with a stated body mass."""

    def make(recording: Recording, trial: Trial) -> Recording | None:
        if trial.forces is None or trial.weighed is None or not trial.motion.events:
            return None
        subject = replace(recording.subject, mass=trial.weighed.mass)
        less = _scaled(recording, lambda time: np.full(len(time), 1 - share))
        return replace(less, subject=subject)

    return make


def _of_mass(recording: Recording, mass: float | None) -> Recording:
    """Return a recording whose files, that of the standing trial too, state this mass [kg]."""
    still = recording.static
    if still is not None:
        still = replace(still, subject=replace(still.subject, mass=mass))
    return replace(recording, subject=replace(recording.subject, mass=mass), static=still)


def _scaled(
    recording: Recording, factor: Callable[[Float[Array, " n"]], Float[Array, " n"]]
) -> Recording:
    plates = []
    for plate in recording.plates:
        by = factor(plate.time)
        scaled = replace(plate, force=plate.force * by[:, None], free_moment=plate.free_moment * by)
        plates.append(scaled)
    return replace(recording, plates=tuple(plates))


def shifted(marks: Sequence[str], by: Sequence[float], *, static: bool = True) -> Faulty:
    """Return markers that were put elsewhere on their segments, in the standing trial as well.

    Args:
        marks: Their landmarks.
        by: Where they are, in the segment's axes in upright standing: forward, left, up [m].
        static: Whether there is a standing trial; otherwise it is lost.
    """

    def make(recording: Recording, trial: Trial) -> Recording | None:
        assert recording.markers is not None
        known = landmarks_of(recording.markers.names)
        names = [known[mark] for mark in marks if mark in known]
        if not names or (len(names) < len(marks) and len(marks) < 3):
            return None
        human = trial.fit.human
        places = attachments(human)
        x = recording.markers.positions.copy()
        at = np.clip(
            np.searchsorted(trial.fit.time, recording.markers.time), 0, len(trial.fit.time) - 1
        )
        # The fit turns the person to x: offsets turn back to the laboratory's axes.
        c, s = np.cos(trial.fit.heading), np.sin(trial.fit.heading)
        back = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
        for mark in marks:
            if mark not in known:
                continue
            body = human.body(places[mark].body)
            stands = body_paths(human, human.standing()[None], [body])[1][0, 0]
            axes = body_paths(human, trial.fit.qpos, [body])[1][:, 0]
            x[:, recording.markers.index(known[mark])] += (axes @ (stands.T @ np.array(by)))[
                at
            ] @ back.T
        found = replace(recording, markers=replace(recording.markers, positions=x))
        still = recording.static
        if still is None or still.markers is None or not static:
            return replace(found, static=None)
        y = still.markers.positions.copy()
        facing = _facing(still)
        for name in names:
            if name in still.markers.names:
                y[:, still.markers.index(name)] += facing @ np.array(by)
        return replace(found, static=replace(still, markers=replace(still.markers, positions=y)))

    return make


def _facing(still: Recording) -> Float[Array, "3 3"]:
    """Return the axes of a person who stands, in the laboratory."""
    assert still.markers is not None
    known = landmarks_of(still.markers.names)
    right, left = (
        np.nanmean(still.markers.positions[:, still.markers.index(known[f"asis_{side}"])], axis=0)
        if f"asis_{side}" in known
        else np.array([0.0, 1.0 if side == "l" else -1.0, 0.0])
        for side in SIDES
    )
    y = (left - right) * [1, 1, 0]
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, [0, 0, 1.0]), y, [0, 0, 1.0]], axis=1)


BELT = ("asis_r", "asis_l", "psis_r", "psis_l", "sacrum")
PARTS: dict[str, dict[str, Fault]] = {
    "sound": {"": Fault(lambda recording, trial: recording, "")},
    "clock": {
        "all 1.2 times too slow": Fault(clock(1.2), "frame rate"),
        "all 1.2 times too fast": Fault(clock(1 / 1.2), "frame rate"),
        "markers 1.2 times too slow, plates right": Fault(clock(1.2, plates=False), "frame rate"),
        "1.2 times too slow, without plates": Fault(without_plates(clock(1.2)), "frame rate"),
        "1.2 times too fast, without plates": Fault(without_plates(clock(1 / 1.2)), "frame rate"),
        "plates 3 % too slow": Fault(
            clock(1.03, motion=False), "drift|rate of the (force )?plates"
        ),
        "plates 3 % too fast": Fault(
            clock(0.97, motion=False), "drift|rate of the (force )?plates"
        ),
    },
    "laboratory": {
        "sways by 3 cm at 0.3 Hz": Fault(sway(0.03, 0.0, 0.3), "sway"),
        "turns by 2° at 0.3 Hz": Fault(sway(0.0, 2.0, 0.3), "sway"),
    },
    "forces": {
        "halved, no body mass": Fault(forces_times(0.5), "force plates? (measured|weigh)|halved"),
        "doubled, no body mass": Fault(forces_times(2.0), "force plates? (measured|weigh)|doubled"),
        "cane of 15 %": Fault(cane(0.15), "else carries|support"),
        "cane of 15 %, no body mass": Fault(cane(0.15, stated=False), "else carries|support"),
        "handrail of 15 %": Fault(handrail(0.15), "else carries|support|body mass is given"),
    },
    "markers": {
        "right knee 4 cm low": Fault(shifted(["knee_lateral_r"], (0, 0, -0.04)), "knee"),
        "both knees 4 cm low": Fault(
            shifted(["knee_lateral_r", "knee_lateral_l"], (0, 0, -0.04)), "knee"
        ),
        "left ankle 3 cm high": Fault(shifted(["ankle_lateral_l"], (0, 0, 0.03)), "ankle"),
        "right heel 4 cm high": Fault(shifted(["heel_r"], (0, 0, 0.04)), "heel"),
        "left heel 3 cm ahead": Fault(shifted(["heel_l"], (0.03, 0, 0)), "heel"),
        "belt 5 cm low, without standing trial": Fault(
            shifted(BELT, (0, 0, -0.05), static=False), "spines|pelvis"
        ),
    },
}
"""Part → name → the fault."""
FAULTS = {name: fault for part in PARTS.values() for name, fault in part.items()}


def outcome(path: Path, name: str) -> dict[str, Any]:
    """Return what a fit says of a recording with a fault."""
    settings = FitSettings()
    recording, sound = _sound(path)
    if not name:
        wrong = [str(n) for n in _first(sound)]
        return {"outcome": "named" if wrong or status(sound) != "ok" else "silent", "said": wrong}
    fault = FAULTS[name]
    faulty = fault.make(recording, sound)
    if faulty is None:
        return {"outcome": "", "said": []}
    try:
        trial = analyse(fit_recording(faulty, settings))
        verdict = status(trial)
    except PlantigradeError as error:
        return {"outcome": "refused", "said": [str(error)]}
    before = {_plain(n) for n in _notes(sound)}
    new = [str(n) for n in _notes(trial) if _plain(n) not in before]
    named = any(re.search(fault.cause, n) for n in new)
    if verdict != "ok":
        return {"outcome": "refused", "said": [verdict, *new]}
    return {"outcome": "named" if named else "warned" if new else "silent", "said": new}


@lru_cache(maxsize=4)
def _sound(path: Path) -> tuple[Recording, Trial]:
    """Return a recording as it is, and its analysis."""
    recording = load(path, FitSettings())
    return recording, analyse(fit_recording(recording, FitSettings()))


def _first(trial: Trial) -> list[str]:
    """Return the warnings on faults."""
    return [*Plausibility.of(trial).notes, *trial.fit.doubts]


def _notes(trial: Trial) -> list[str]:
    every = [*Plausibility.of(trial).notes, *trial.record().notes]
    return [note for note in every if not isinstance(note, Info)]


def _plain(note: str) -> str:
    return NUMBERS.sub("…", note)


def half_of(path: Path) -> str:
    """Return in which half the person of a recording is."""
    return "settled on" if any(who in str(path) for who in SETTLING_PEOPLE) else "others"


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the share of recordings in which each fault is named or refused, for both halves."""
    for half in ("settled on", "others"):
        for name in FAULTS:
            found = [r["outcome"] for r in cached.select(half, name or "sound").values()]
            found = [each for each in found if each]
            if not found:
                continue
            if not name:
                yield equal(half, "sound, accused", sum(f != "silent" for f in found), 0)
                continue
            named = 100.0 * float(np.mean([f in ("refused", "named") for f in found]))
            yield at_least(half, f"{name}, named", named, 100.0, "%")


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return fault and recording → outcome, for both halves."""
    for half in ("settled on", "others"):
        lines, names = [], {}
        for key, result in cached.select(half).items():
            _, fault, *rest = key.split("/")
            names.setdefault("/".join(rest), {})[fault] = result["outcome"]
        for fault in ("sound", *filter(None, FAULTS)):
            found = [own[fault] for own in names.values() if own.get(fault)]
            if found:
                counts = [str(found.count(each)) for each in OUTCOMES]
                silent = [n for n, own in names.items() if own.get(fault) == "silent"]
                last = "" if fault == "sound" else ", ".join(silent[:6])
                lines.append([fault, *counts, last])
        yield Grid(f"Recordings {half}", ("fault", *OUTCOMES, "silent in"), lines)


def experiment(data: Path) -> Specification:
    """Return the experiment on the recordings with markers of a folder."""
    files = sorted([*data.rglob("*.c3d"), *data.rglob("*.trc")])

    def cases(part: str, quick: bool) -> Cases:
        return {
            f"{half_of(path)}/{name or 'sound'}/{path.stem}": partial(outcome, path, name)
            for path in (files[:1] if quick else files)
            for name in PARTS[part]
        }

    return Specification(
        name="recording-faults",
        title="Hidden faults of recordings",
        parts={part: partial(cases, part) for part in PARTS},
        summary=lambda result: str(result["outcome"] or "cannot have it"),
        rows=rows,
        grids=grids,
        notes=NOTES,
    )


NOTES = (
    "",
    "refused: the run is not ok, or ends with an error; named: a warning that the sound recording "
    "does not have names the cause; warned: another warning; silent: none. A sound recording is "
    "accused where one of its first warnings is of a fault.",
)


def run(data: Path, **options: Any) -> ResultTable:
    """Run the experiment.

    Args:
        data: Folder of recordings.
        options: Options of :meth:`~experiments.specification.Specification.run`.
    """
    return experiment(data).run(**options)
