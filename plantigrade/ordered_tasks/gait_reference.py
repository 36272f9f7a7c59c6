"""Reference of a reproduced gait: task inputs from a recording and the recording for comparison.

The tasks use the contact intervals of each region of each foot, the horizontal paths of the heels,
the path of the centre of mass, and the posture at the end of each phase. The remaining motion
serves for comparison only.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import contact_sites
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.contacts import foot_contacts
from plantigrade.kinematics.fitted_soles import on_own_soles
from plantigrade.kinematics.sole_paths import SolePaths, sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Motion
from plantigrade.motion.filters import resample
from plantigrade.motion.recording import even_clock, rate_of
from plantigrade.ordered_tasks.phases import Phase, phases_between, walking_events
from plantigrade.ordered_tasks.stationary_contacts import stationary_contacts
from plantigrade.spatial.conventions import continuous_poses


@dataclass(frozen=True)
class GaitReference:
    """A recorded gait with the inputs of the tasks.

    Attributes:
        human: The person, with soles fitted to the recording.
        motion: The recorded motion over stationary ground, with consecutive gait events; the
            reproduction lasts from the first to the last.
        phases: Phases between the events.
        contacts: Contact interval of each region of each foot, from gait events and speeds.
        held: Contact intervals limited to the time in which the region is stationary.
        com: Path of the centre of mass [m].
        heel: Path of each heel, by side [m].
        heel_point: The heel of each side: middle of its contact sites.
    """

    human: Human
    motion: Motion
    phases: tuple[Phase, ...]
    contacts: tuple[ContactInterval, ...]
    held: tuple[ContactInterval, ...]
    com: Trajectory
    heel: dict[str, Trajectory]
    heel_point: dict[str, PointSet]

    @property
    def events(self) -> tuple[GaitEvent, ...]:
        """Consecutive gait events."""
        return self.motion.events

    @property
    def start(self) -> float:
        """First event [s]."""
        return self.events[0].time

    @property
    def stop(self) -> float:
        """Last event [s]."""
        return self.events[-1].time

    def at(self, time: float | Float[Array, " n"]) -> Float[Array, "*n nq"]:
        """Return the recorded configuration at a time or times."""
        times = np.atleast_1d(np.asarray(time, float))
        qpos = resample(self.motion.time, self.motion.qpos, times)
        qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
        return qpos[0] if np.ndim(time) == 0 else qpos

    def velocity_at(self, time: float) -> Float[Array, " nv"]:
        """Return the recorded velocity at a time."""
        return resample(self.motion.time, self.motion.qvel, np.array([time]))[0]


def reference_of(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    events: Sequence[GaitEvent],
    *,
    ground: Float[Array, "n_frames 3"] | None = None,
) -> GaitReference:
    """Return the reference of a recorded gait.

    Args:
        time: Time of each frame [s].
        qpos: The recorded motion, smoothed.
        ground: Path of the ground, such as a treadmill's belt [m]; stationary if absent.

    Raises:
        ReproduceError: If the recording has fewer than two consecutive phases of walking.
    """
    events = tuple(sorted(events, key=lambda e: e.time))
    walking = walking_events(events)
    if len(walking) < 3:
        raise ReproduceError(
            f"the recording shows {len(walking)} consecutive gait events; a reproduced gait needs "
            "at least three (two phases): heel strike, the other foot's toe off, its heel strike. "
            "Give a recording with at least two steps of walking"
        )
    time = even_clock(time)
    qpos = continuous_poses(qpos)
    if ground is not None:
        qpos[:, :3] -= ground
    contact = sole_paths(human, qpos)
    rests = find_rests(contact, rate_of(time))
    human = on_own_soles(human, contact, rests)
    smooth = differentiate(human, time, qpos, None)
    heel_point = {side: _heel(human, contact, side) for side in SIDES}
    contacts = foot_contacts(time, events, rests)
    return GaitReference(
        human=human,
        motion=Motion(time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc, walking),
        phases=phases_between(walking),
        contacts=contacts,
        held=stationary_contacts(human, time, smooth.qpos, contacts),
        com=Trajectory(time, np.array([state.com for state in sweep(human, smooth.qpos)])),
        heel={s: Trajectory(time, heel_point[s].path(smooth.qpos)[:, 0]) for s in SIDES},
        heel_point=heel_point,
    )


def _heel(human: Human, contact: SolePaths, side: str) -> PointSet:
    """Return the heel point, the mean of the heel's contact sites."""
    sites = [contact_sites(human)[i] for i in contact.of(side, "heel")]
    local = np.mean([site.position for site in sites], axis=0)
    return PointSet(human, [sites[0].body], local[None])
