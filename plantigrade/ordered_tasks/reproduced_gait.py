"""A gait reproduced from a recording with prioritised tasks, with or without forces."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.constants import FRICTION
from plantigrade.contact.ground import Ground
from plantigrade.ordered_tasks.forces import ForcedGaitSettings, forced_order
from plantigrade.ordered_tasks.gait import GaitSettings, GaitTasks, gait_order, phase_ends
from plantigrade.ordered_tasks.gait_reference import GaitReference
from plantigrade.ordered_tasks.gait_support import GaitSupport, SupportSettings, gait_support
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.record import Record
from plantigrade.wbc.forces import Footing, ForceSettings
from plantigrade.wbc.stepping import MotionSettings, OrderedMotion, move


@dataclass(frozen=True, kw_only=True)
class ReproducedGaitSettings:
    """Settings of a reproduced gait, by component."""

    gait: GaitSettings = GaitSettings()  #: Gains of the tasks
    forced: ForcedGaitSettings = ForcedGaitSettings()  #: Gains of a gait with forces
    #: Trade-off between the recorded path and the estimated forces
    support: SupportSettings = SupportSettings()
    forces: ForceSettings = ForceSettings()  #: Bounds and costs of contact forces
    motion: MotionSettings = MotionSettings()  #: Settings of the integration


@dataclass(frozen=True)
class ReproducedGait:
    """A recorded gait and the motion reproduced from it."""

    reference: GaitReference  #: Inputs of the tasks from the recording
    tasks: GaitTasks  #: The tasks
    motion: OrderedMotion  #: The reproduced motion
    friction: float = FRICTION  #: Coefficient of friction
    #: Ground reactions and consistent paths; None for a motion without forces
    support: GaitSupport | None = None

    def record(self) -> Record:
        """Return the reproduced motion with the recorded one as ``references["recorded"]``.

        The reference keeps its own frame times; :meth:`Motion.at` resamples it.
        """
        reference, record = self.reference, self.motion.record()
        by_forces = self.motion.qfrc is not None
        schedule = ContactSchedule(reference, None if by_forces else reference.held)
        return replace(
            record,
            motion=replace(record.motion, events=reference.events),
            sites=schedule.points.sites,
            contact_planned=np.array([schedule(float(t)) for t in self.motion.time]),
            ground=Ground(friction=self.friction),
            signals={**record.signals, **self._gait_signals()},
            references={"recorded": reference.motion},
        )

    def _gait_signals(self) -> dict[str, np.ndarray]:
        """Return phases, posture instants, contacts and estimated forces of the recording."""
        phases, contacts = self.reference.phases, self.reference.contacts
        posture, support, time = self.tasks.posture, self.support, self.motion.time
        estimated = {}
        if support is not None:
            wrench = np.array([support.wrench_at(float(t)) for t in time])
            estimated["estimated.force"] = wrench[..., :3]
        return estimated | {
            "phase.span": np.array([(p.start, p.stop) for p in phases]).reshape(-1, 2),
            "phase.kind": np.array([p.kind for p in phases], dtype=np.str_),
            "phase.swing": np.array([p.swing for p in phases], dtype=np.str_),
            "posture.end": (
                phase_ends(self.reference, self.tasks.phases) if posture else np.zeros(0)
            ),
            "contact.span": np.array([(c.start, c.stop) for c in contacts]).reshape(-1, 2),
            "contact.place": np.array([f"{c.region}_{c.side}" for c in contacts], dtype=np.str_),
        }


def rebuild(
    reference: GaitReference, tasks: GaitTasks | None = None, *, forces: bool = False
) -> ReproducedGait:
    """Reproduce a recorded gait from prioritised tasks.

    Args:
        tasks: Which tasks; the default ones if absent.
        forces: Whether joint moments and ground reactions are part of the solution.

    Raises:
        ParameterError: If the division into phases is unknown.
        SolverError: If the first tick has no solution.
    """
    tasks, s = tasks or GaitTasks(), ReproducedGaitSettings()
    if forces:
        support = gait_support(reference, s.support)
        reference, order = support.reference, forced_order(support, tasks, s.forced, s.gait)
        ground = Footing(FRICTION, support.wrench_at, s.forces)
    else:
        order, ground, support = gait_order(reference, tasks, settings=s.gait), None, None
    motion = move(
        reference.human,
        order,
        reference.at(reference.start),
        reference.velocity_at(reference.start),
        start=reference.start,
        stop=reference.stop,
        settings=s.motion,
        ground=ground,
    )
    return ReproducedGait(reference, tasks, motion, FRICTION, support)
