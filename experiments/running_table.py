"""Generated running beside a recorded runner: times, forces, angles, and the foot at touchdown.

The runner's recordings are fitted with their force plates; the task is given the height and mass of
the person and the speed of the treadmill, no recording. The weights of the task were set with the
recording at 3 m/s in view, so that the one at 2 m/s is the test.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.synthesis_trial import check_motion, solve
from experiments.table import ResultTable, Row, at_least, between, equal, over_trials, within
from plantigrade.analyze.curves import GaitCurves, gait_curves
from plantigrade.analyze.feet import foot_path
from plantigrade.analyze.gait import gait_measures
from plantigrade.analyze.statistics import Agreement, compare_curves, known_mean
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.trajopt.tasks.registry import make_task
from plantigrade.workflows.fit import fit_trial

SPEEDS = {
    "opensim/running_subject04/run200.trc": 2.0,
    "opensim/running_subject04/run300.trc": 3.0,
}
"""Recording → speed of the treadmill [m/s]."""
WALKS = tuple(SPEEDS)
QUICK_TRIALS = WALKS[1:]
MAX_PEAK_DIFFERENCE = 12.0  # [%] goal of the peak of the vertical force
MAX_CONTACT_TIME_DIFFERENCE = 15.0  # [%] goal of the contact time
KNEE = (15.0, 25.0)  # [deg] knee flexion at strike of runners who land on their heels
CORRELATION = {"hip_flexion": 0.9, "knee_angle": 0.9, "ankle_angle": 0.8}
FORCES = {"vertical force": "up", "forward force": "forward"}
LANDING_TIME = 0.01  # [s] before the strike over which the speed of the heel is averaged
NOTES = (
    "One runner [Hamner2013]; weights of the task were set with the recording at 3 m/s in view.",
    "The heel's speed at touchdown is the mean over the last 10 ms before it.",
)


@dataclass(frozen=True, eq=False)
class Gait:
    """One gait, generated or recorded, as means over cycles and feet."""

    cadence: float  #: [steps/min]
    contact: float  #: Contact time [s]
    heel_down: float  #: Downward speed of the heel before it strikes [m/s]
    curves: dict[str, Float[Array, " n_percent"]]  #: Angle [deg] or force [body weights] by name

    @classmethod
    def of(cls, record: Record) -> "Gait":
        """Return the gait of a record."""
        motion, feet = record.motion, foot_path(record.human, record.motion.qpos)
        measures = gait_measures(motion.time, feet.heel, feet.toe, motion.events)
        return cls(
            measures.cadence.mean,
            known_mean(s.mean for s in measures.contact_time.values()),
            landing_speed(record, feet.heel),
            mean_curves(gait_curves(record)),
        )


def landing_speed(record: Record, heel: Float[Array, "n_frames 2 3"]) -> float:
    """Return the mean downward speed of the heel in the last :data:`LANDING_TIME` [m/s]."""
    time, found = record.motion.time, []
    for event in record.motion.events:
        if event.kind == "heel_strike" and event.time >= time[0] + LANDING_TIME:
            height = heel[:, SIDES.index(event.side), 2]
            before, at = np.interp([event.time - LANDING_TIME, event.time], time, height)
            found.append((before - at) / LANDING_TIME)
    return known_mean(found)


def mean_curves(curves: GaitCurves) -> dict[str, Float[Array, " n_percent"]]:
    """Return the mean curves of both feet."""
    both = {n: [curves.angles[f"{n}_{s}"] for s in SIDES] for n in CORRELATION}
    both |= {a: [curves.forces[f"{a}_{s}"] for s in SIDES] for a in FORCES.values()}
    return {name: np.nanmean(np.concatenate(rows), axis=0) for name, rows in both.items()}


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the recordings of running in a data folder."""
    title = "Generated running beside a recorded runner"
    return over_trials(
        title, data, QUICK_TRIALS if quick else WALKS, trial_rows, say=say, notes=NOTES
    )


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one recording."""
    speed = SPEEDS[name]
    trial = fit_trial(path)[1]
    person = trial.fit.human
    human = Human.create(person.height, person.mass, joints="43", feet="two-segment")
    timed = solve(human, make_task("run", human, {"speed": speed}))
    made = check_motion(timed, strides=2)
    key = f"{speed:g} m/s"
    return [
        equal(key, "passes the check", float(made.ok), 1, "", "" if made.ok else made.status),
        Row(key, "processor time", timed.cpu, "s"),
        *rows_beside(key, Gait.of(made.record), Gait.of(trial.record())),
    ]


def rows_beside(key: str, made: Gait, recorded: Gait) -> Iterable[Row]:
    """Yield the figures of a generated gait, those of the recorded one after them."""
    yield Row(key, "cadence", made.cadence, "steps/min")
    yield Row(key, "cadence, recorded", recorded.cadence, "steps/min")
    yield _beside(
        key, "contact time", made.contact, recorded.contact, MAX_CONTACT_TIME_DIFFERENCE, "s"
    )
    yield Row(key, "contact time, recorded", recorded.contact, "s")
    for quantity, axis in FORCES.items():
        mine, measured = made.curves[axis], recorded.curves[axis]
        limit = MAX_PEAK_DIFFERENCE if axis == "up" else None
        unit = "body weights"
        yield _beside(
            key, f"peak {quantity}", float(mine.max()), float(measured.max()), limit, unit
        )
        yield Row(key, f"peak {quantity}, recorded", float(measured.max()), unit)
        yield Row(key, f"{quantity}, r", compare_curves(mine, measured).correlation)
    for angle, least in CORRELATION.items():
        agreement: Agreement = compare_curves(made.curves[angle], recorded.curves[angle])
        yield at_least(key, f"{angle}, r", agreement.correlation, least)
        yield Row(key, f"{angle}, RMS", agreement.rmse, "deg")
    knee = "knee_angle"
    yield between(key, "knee at strike", float(made.curves[knee][0]), *KNEE, "deg")
    yield Row(key, "knee at strike, recorded", float(recorded.curves[knee][0]), "deg")
    yield Row(key, "knee in swing, most", float(made.curves[knee].max()), "deg")
    yield Row(key, "knee in swing, most, recorded", float(recorded.curves[knee].max()), "deg")
    yield Row(key, "heel's speed down at touchdown", made.heel_down, "m/s")
    yield Row(key, "heel's speed down at touchdown, recorded", recorded.heel_down, "m/s")


def _beside(
    key: str, quantity: str, value: float, recorded: float, limit: float | None, unit: str
) -> Row:
    """Return a row whose figure should be within a percentage of the recorded one."""
    off = 100.0 * (value / recorded - 1.0)
    judged = within(key, quantity, off, limit)
    goal = "" if limit is None else f"{recorded:.3g} ± {limit:g} %"
    return Row(key, quantity, value, unit, goal, judged.met, f"{off:+.0f} %")
