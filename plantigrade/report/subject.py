"""What a report is about: a run, and what several sections compute from it."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.curves import GaitCurves, gait_curves
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.record import Record, Run
from plantigrade.report.scene import side_forces

LEG_LENGTHS = ("thigh", "shank", "ankle_height")


class Subject:
    """A run and what is computed from it once.

    Attributes:
        run: The run.
        record: Its record.
        forces: The record whose forces are shown: the run's own, or the motion moved by forces
            that lies beside it; equal to ``record`` where there is none.
        figures: The figures of the run.
    """

    def __init__(self, run: Run):
        """Take what there is."""
        self.run, self.record = run, run.record
        self.figures: Mapping[str, Any] = run.figures
        beside = run.others.get("forces")
        lost = self.figures.get("dynamics_status", "ok") != "ok"
        use = not lost and not run.record.has_forces
        self.forces: Record = beside if beside is not None and use else run.record

    @cached_property
    def angle_curves(self) -> GaitCurves:
        """Joint angles over the gait cycle."""
        return gait_curves(self.record)

    @cached_property
    def force_curves(self) -> GaitCurves:
        """Forces, moments and powers over the gait cycle."""
        same = self.forces is self.record
        return self.angle_curves if same else gait_curves(self.forces)

    @cached_property
    def comparison(self) -> Comparison:
        """The motion beside the recorded one."""
        return compare(self.record)

    @cached_property
    def side_forces(self) -> tuple[Array | None, Array | None]:
        """Ground reaction and centre of pressure: right, left, side unknown [N, m]."""
        return side_forces(self.forces)

    @property
    def walks(self) -> bool:
        """Whether there is a whole gait cycle."""
        return bool(self.angle_curves.cycles)

    @property
    def foot_off(self) -> dict[str, float]:
        """Side → percent of the gait cycle at which its foot leaves the ground."""
        stance = {side: self.number(f"stance_{side}_pct") for side in SIDES}
        return {side: value for side, value in stance.items() if value is not None}

    @cached_property
    def speed_class(self) -> str:
        """The class of walking speed whose published values are shown."""
        speed = self.number("walking_speed_m_s")
        lengths = [self.number(f"length_{name}_m") for name in LEG_LENGTHS]
        known = [length for length in lengths if length is not None]
        if speed is None or len(known) < len(lengths):
            return "free"
        return norms.speed_class(speed, sum(known))

    def number(self, key: str) -> float | None:
        """Return a figure of the run; None where it is not known."""
        value = self.figures.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            return None
        return float(value) if np.isfinite(float(value)) else None

    def words(self, name: str) -> tuple[str, ...]:
        """Return a signal of words; none where the record has no such signal."""
        return tuple(str(word) for word in self.record.signals.get(name, ()))
