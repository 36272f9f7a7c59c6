"""External wrenches of a recorded motion, acting again in the simulated world."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import PUSH_PART, ContactSite
from plantigrade.record import Record
from plantigrade.world.disturbance import Disturbance
from plantigrade.world.simulated_world import SimulatedWorld


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedWrench(Disturbance):
    """A wrench on the body that belongs to a motion: the weight of a box, the pull of a cart.

    It acts at the same point of the body as in the record, in world axes, at the same time; after
    the last frame it keeps its last value, or begins again if the motion is periodic.
    """

    interval = 0.01  # [s], within which forces of tasks change by a few newtons
    site: ContactSite  #: Point of the body
    times: Float[Array, " n"]  #: Times of the frames, from zero on [s]
    force: Float[Array, "n 3"]  #: Force [N]
    moment: Float[Array, "n 3"]  #: Free moment [N m]
    period: float = np.inf  #: Period of the motion [s]; infinite if it has none

    def act(self, world: SimulatedWorld) -> None:
        """Apply the wrench of this instant."""
        time = world.time % self.period if np.isfinite(self.period) else world.time
        force, moment = (
            np.array([np.interp(time, self.times, values[:, axis]) for axis in range(3)])
            for values in (self.force, self.moment)
        )
        data, body = world.data, world.human.body(self.site.body)
        rotation = data.xmat[body].reshape(3, 3)
        point = data.xpos[body] + rotation @ np.asarray(self.site.position)
        if force.any():
            world.push(body, force, point - data.xipos[body])
        if moment.any():  # as a couple of forces, one metre apart
            across = np.cross(moment, np.eye(3)[np.argmin(np.abs(moment))])
            arm = across / np.linalg.norm(across)
            pair = np.cross(moment, arm)  # arm × (moment × arm) = moment, as arm ⟂ moment
            world.push(body, pair, 0.5 * arm)
            world.push(body, -pair, -0.5 * arm)


def recorded_wrenches(record: Record, period: float | None = None) -> tuple[RecordedWrench, ...]:
    """Return what acts on the body in a record besides ground, seats and supports.

    Args:
        period: Its period [s]; None if it has none.
    """
    if record.contact_force is None:
        return ()
    moment = record.contact_torque
    found = []
    for k, site in enumerate(record.sites):
        force = np.nan_to_num(record.contact_force[:, k])
        turning = np.zeros_like(force) if moment is None else np.nan_to_num(moment[:, k])
        if site.part == PUSH_PART and (force.any() or turning.any()):
            times = record.motion.time - record.motion.time[0]
            lasting = np.inf if period is None else period
            found.append(
                RecordedWrench(site=site, times=times, force=force, moment=turning, period=lasting)
            )
    return tuple(found)
