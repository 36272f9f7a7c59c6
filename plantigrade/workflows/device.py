"""What a device saves, in comparison with the same task without it."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from plantigrade.arrays import Array, Float
from plantigrade.models import Human
from plantigrade.motion.filters import interpolate
from plantigrade.notes import Info
from plantigrade.record import Record, Run
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.solution import Solution
from plantigrade.trajopt.solve import synthesize
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.device import Device

N_KEPT_MOTIONS = 2  # motions without a device that are kept, as starts of the next ones in a sweep


@dataclass(frozen=True, eq=False)
class _Place:
    """A task with devices, known by ``key``: what decides everything but their sizes."""

    key: tuple[Any, ...]
    human: Human
    task: MotionTask
    strides: int

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Place) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


@dataclass(frozen=True, eq=False)
class WithoutDevices:
    """The task without devices, from which the one with devices starts."""

    worn: ContactBody  #: Body with devices at the joints of the task
    bare: Solution  #: The task without devices
    record: Record  #: Its record


def without_devices(
    human: Human, task: MotionTask, strides: int, key: tuple[Any, ...]
) -> WithoutDevices:
    """Return the task whose devices are taken off, solved, and a body for the one with them.

    Args:
        strides: Of the record.
        key: What decides everything but the devices, hashable; motions of one key are solved once.
    """
    joints = tuple(d.coordinate for d in task.devices)
    return _solved(_Place((*key, joints, strides), human, task, strides))


@lru_cache(maxsize=N_KEPT_MOTIONS)
def _solved(what: _Place) -> WithoutDevices:
    terms = tuple(t for t in what.task.terms if not isinstance(t, Device))
    plain = replace(what.task, terms=terms)
    bare = synthesize(plain.body_of(what.human), plain)
    return WithoutDevices(what.task.body_of(what.human), bare, bare.record(strides=what.strides))


def compared(run: Run, bare: Record) -> Run:
    """Return a run with what its devices save, compared with a motion without them.

    Work is over the motion, and that of the person has the joint torque less that of devices.

    Args:
        run: The motion with devices.
        bare: The same task without.
    """
    record, human = run.record, run.record.human
    assert record.qfrc_actuator is not None and bare.qfrc_actuator is not None
    device = record.device_torque
    own, before = record.qfrc_actuator - device, bare.qfrc_actuator
    worn = np.flatnonzero(device.any(axis=0)).tolist()
    figures: dict[str, Any] = {}
    for name in dict.fromkeys(human.coordinates[i - 6][:-2] for i in worn):
        at = [i for i in worn if human.coordinates[i - 6][:-2] == name]
        done = _positive(record, own, at), _positive(bare, before, at)
        most = [float(np.abs(x[:, at]).max()) for x in (device, own, before)]
        figures |= {
            f"device_{name}_peak_n_m": most[0],
            f"device_{name}_positive_work_j": _positive(record, device, at),
            f"device_{name}_own_peak_n_m": most[1],
            f"device_{name}_own_peak_without_n_m": most[2],
            f"device_{name}_own_positive_work_j": done[0],
            f"device_{name}_own_positive_work_without_j": done[1],
        }
    every = list(range(6, device.shape[1]))
    work = _positive(record, own, every), _positive(bare, before, every)
    effort = [float(np.mean(x[:, 6:] ** 2)) for x in (own, before)]
    figures["device_own_work_change_pct"] = 100.0 * (work[0] / work[1] - 1.0)
    figures["device_own_torque_change_pct"] = 100.0 * (np.sqrt(effort[0] / effort[1]) - 1.0)
    without = interpolate(record.motion.time, bare.motion.time, before)
    signals = {**record.signals, "device.without": without}
    sentence = _sentence(figures)
    record = replace(record, signals=signals, notes=(*record.notes, Info(sentence)))
    return replace(run, record=record, figures={**run.figures, **figures})


def _positive(record: Record, torque: Float[Array, "n nv"], at: list[int]) -> float:
    """Return the positive work of hinges over the motion [J]."""
    time = record.motion.time
    power = np.clip(torque[:, at] * record.motion.qvel[:, at], 0.0, None)
    return float(trapezoid(power, time, axis=0).sum())


def _sentence(figures: dict[str, Any]) -> str:
    """Return what devices save in words."""
    joints = [n.removeprefix("device_").removesuffix("_own_peak_n_m") for n in figures
              if n.endswith("_own_peak_n_m")]  # fmt: skip
    parts = []
    for name in joints:
        of = {k: figures[f"device_{name}_{k}"] for k in (
            "peak_n_m", "own_peak_n_m", "own_peak_without_n_m",
            "own_positive_work_j", "own_positive_work_without_j",
        )}  # fmt: skip
        before = of["own_positive_work_without_j"]
        saved = 100.0 * (of["own_positive_work_j"] / before - 1.0) if before else float("nan")
        parts.append(
            f"at {name} the device adds up to {of['peak_n_m']:.0f} N m, and the person needs "
            f"{of['own_peak_n_m']:.0f} N m ({of['own_peak_without_n_m']:.0f} without it) and "
            f"{saved:+z.0f} % positive work"
        )
    whole = (
        f"all joints together do {figures['device_own_work_change_pct']:+z.0f} % positive work, "
        f"with {figures['device_own_torque_change_pct']:+z.0f} % torque (RMS)."
    )
    text = "; ".join((*parts, whole))
    return text[0].upper() + text[1:]
