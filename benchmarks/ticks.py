"""One tick of a reproduced gait: the hierarchical program, and kinematics with Jacobians and rows.

Beside Pink and mink where they are installed: the same body, the same textbook walk, the same
three tasks (both heels, centre of mass, posture), all in one run. Theirs are weighted, not
ordered: one quadratic program whose weights decide where tasks conflict.
"""

import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from experiments.table import Row, at_most
from plantigrade.constants import SIDES
from plantigrade.errors import PlantigradeError
from plantigrade.kinematics.textbook_recording import textbook_walk
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.ordered_tasks import TASKS, gait_order
from plantigrade.ordered_tasks.gait_reference import GaitReference, reference_of
from plantigrade.wbc.order import TaskOrder
from plantigrade.wbc.stepping import MotionSettings, move
from plantigrade.wbc.tasks import ComTask, PointTask, TimedPosture

RECORDING = "c3d/HC038A11.c3d"
STEP = MotionSettings.step
REPEATS = 3  # runs of which the fastest counts, tick by tick
ROUNDS = 3  # of ours and theirs in turn
# Goals
MAX_PROGRAM_TIME = 0.2  # [ms]
MAX_TICK_TIME = 0.4  # [ms]
MAX_CYCLE_TIME = 0.2  # [s]
MAX_TIME_RATIO = 1.0  # [1] of our time by that of the other


def rows(data: Path | None, python: str) -> Iterator[Row]:
    """Yield the figures of the textbook walk, of a recording if there is one, and the peers'."""
    walk = textbook()
    for tasks in ("paper", "default"):
        yield from gait_rows(f"textbook walk, {tasks}", walk, tasks)
    if data is None or not (data / RECORDING).exists():
        yield Row(RECORDING, "not measured", None, note="no such recording")
    else:
        try:
            recorded = recording(data / RECORDING)
        except PlantigradeError as error:
            yield Row(RECORDING, "not measured", None, note=str(error))
        else:
            for tasks in ("paper", "default"):
                yield from gait_rows(f"{Path(RECORDING).name}, {tasks}", recorded, tasks)
    yield from beside(walk, python)


def textbook() -> GaitReference:
    """Return the textbook walk as the tasks see it."""
    walk = textbook_walk(Human.create(), cycles=3)
    return reference_of(walk.human, walk.time, walk.qpos, walk.events)


def recording(path: Path) -> GaitReference:
    """Return a recorded gait as the tasks see it."""
    from plantigrade.analyze.recorded_walk import RecordedWalk
    from plantigrade.workflows.fit import fit_trial

    return RecordedWalk.of(fit_trial(path)[1]).reference()


def gait_rows(subject: str, reference: GaitReference, tasks: str) -> Iterator[Row]:
    """Yield time per tick and per cycle of one gait."""
    program, state, share, exact, whole = timed(reference, gait_order(reference, TASKS[tasks]))
    both = program + state
    nv, n = reference.human.model.nv, len(program)
    note = f"{nv} coordinates, {n} ticks, {100 * exact:.0f} % without active inequality"
    yield replace(
        at_most(subject, "program, median", *ms(program), MAX_PROGRAM_TIME, "ms"), note=note
    )
    yield Row(subject, "program, 95th percentile", 1e3 * float(np.percentile(program, 95)), "ms")
    yield Row(subject, "of it in DAQP", 100 * share, "%")
    yield Row(subject, "kinematics, Jacobians, rows, median", *ms(state), "ms")
    yield at_most(subject, "both, median", *ms(both), MAX_TICK_TIME, "ms")
    cycle = whole / (reference.stop - reference.start) * stride(reference)
    yield at_most(subject, "one gait cycle", cycle, MAX_CYCLE_TIME, "s")


def ms(seconds: np.ndarray) -> tuple[float]:
    """Return the median in milliseconds."""
    return (1e3 * float(np.median(seconds)),)


def stride(reference: GaitReference) -> float:
    """Return the mean time of a stride [s]."""
    strikes = {s: [e.time for e in reference.events if (e.side, e.kind) == (s, "heel_strike")]
               for s in SIDES}  # fmt: skip
    times = np.concatenate([np.diff(t) for t in strikes.values()])
    return float(times.mean()) if len(times) else reference.stop - reference.start


def timed(reference: GaitReference, order: TaskOrder):
    """Return times per tick of program and state, DAQP's share, exact ticks, and the whole [s]."""
    import daqp

    program = state = whole = np.inf
    share, exact, solve = 0.0, 0.0, daqp.solve
    start = reference.at(reference.start), reference.velocity_at(reference.start)
    for _ in range(REPEATS):
        inside = []

        def clocked(*arguments, inside=inside, **options):
            begin = time.perf_counter()
            answer = solve(*arguments, **options)
            inside.append(time.perf_counter() - begin)
            return answer

        with mock.patch.object(daqp, "solve", clocked):
            begin = time.perf_counter()
            motion = move(
                reference.human, order, *start, start=reference.start, stop=reference.stop
            )
            spent = time.perf_counter() - begin
        program = np.minimum(program, motion.solver_time)
        state = np.minimum(state, motion.kinematics_time)
        whole = min(whole, spent)
        share = sum(inside) / motion.solver_time.sum()
        exact = float(motion.exact.mean())
    return program, state, share, exact, whole


def beside(reference: GaitReference, python: str) -> Iterator[Row]:
    """Yield a tick of ours, of Pink's and of mink's on the same body, walk and tasks."""
    what = "beside weighted tasks"
    rounds = []
    for _ in range(ROUNDS):  # in turn, so that whatever else runs here slows all of them down
        theirs, why = solve_with_peers(reference, python)
        if theirs is None:
            yield Row(what, "not measured", None, note=why)
            return
        rounds.append((theirs, timed(reference, three_tasks(reference))))
    program = np.min([found[0] for _, found in rounds], axis=0)
    state = np.min([found[1] for _, found in rounds], axis=0)
    exact = rounds[0][1][3]
    (ours,) = ms(program + state)
    note = f"ordered, accelerations, joint limits; {100 * exact:.0f} % without active inequality"
    yield Row(what, "ours, tick, median", ours, "ms", note=note)
    yield Row(what, "ours, program alone", *ms(program), "ms")
    yield Row(what, "ours, kinematics, Jacobians, rows", *ms(state), "ms")
    for name, first in rounds[0][0].items():
        if "missing" in first:
            yield Row(what, f"{name} not measured", None, note=first["missing"])
            continue
        theirs = min(found[name]["median_us"] for found, _ in rounds) / 1e3
        note = f"{first['version']}; weighted, not ordered; velocities, no limits"
        yield Row(what, f"{name}, tick, median", theirs, "ms", note=note)
        yield Row(what, f"{name}, centre of mass off by", first["com_mm"], "mm")
        yield at_most(what, f"our tick in {name}'s", ours / theirs, MAX_TIME_RATIO)


class Sampled(Trajectory):
    """A trajectory sampled before the ticks, as the peers' targets are."""

    def __init__(self, path: Trajectory, times: np.ndarray):
        self.start, self.rates = times[0], np.array([path(float(t)) for t in times])

    def __call__(self, time: float) -> np.ndarray:
        """Return value, velocity and acceleration at the nearest sample."""
        return self.rates[min(round((time - self.start) / STEP), len(self.rates) - 1)]


def three_tasks(reference: GaitReference) -> TaskOrder:
    """Return the order of the three tasks the peers are given too."""
    times = np.arange(reference.start, reference.stop + STEP, STEP)
    heels = [
        PointTask(
            reference.heel_point[side], Sampled(reference.heel[side], times), name=f"heel {side}"
        )
        for side in SIDES
    ]
    postures = reference.at(times)

    def now(t: float) -> tuple[np.ndarray, float]:
        return postures[min(round((t - times[0]) / STEP), len(postures) - 1)], t + 0.1

    return TaskOrder([heels, [ComTask(Sampled(reference.com, times))]], TimedPosture(now))


def solve_with_peers(reference: GaitReference, python: str) -> tuple[dict | None, str]:
    """Run Pink and mink in the given interpreter; return their figures, or None and why not."""
    if shutil.which(python) is None:
        return None, f"no Python at {python}"
    human, times = reference.human, np.arange(reference.start, reference.stop, STEP)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "model.xml").write_text(human.xml)
        np.savez(
            folder / "targets.npz",
            joint_names=np.array(human.coordinates),
            joint_counts=[len(b.hinges) for b in human.skeleton.bodies if b.hinges],
            qpos=reference.at(reference.start),
            posture=reference.at(times),
            com=np.array([reference.com(float(t))[0] for t in times]),
            heel=np.array([[reference.heel[s](float(t))[0] for t in times] for s in SIDES]),
            heel_local=np.array([reference.heel_point[s].local[0] for s in SIDES]),
            step=STEP,
        )
        script = Path(__file__).with_name("weighted_ik.py")
        command = [python, str(script), name]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        answer = folder / "figures.json"
        if answer.exists():
            figures = json.loads(answer.read_text())
            if all("missing" in found for found in figures.values()):
                return None, "neither Pink nor mink is there; name a Python with --peers-python"
            return figures, ""
    last = done.stderr.strip().splitlines()
    return None, f"failed: {last[-1] if last else f'exit code {done.returncode}'}"
