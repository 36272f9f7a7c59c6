"""The frames of a world as they happen, and the Record they make.

Every frame is one instant of the physics: configuration, velocity, acceleration and all forces
belong together, so the equations of motion hold in it to the last digits.
"""

from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import PUSH, TOUCH, ContactSite
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.plate_events import contact_events
from plantigrade.motion.recording import GaitEvent
from plantigrade.world.contacts import Contacts, Taken, Touch, Wrench


class Recorder:
    """Keeps frames: :meth:`before` a step of the physics, :meth:`after` it.

    What can wait until the end is not computed in between.
    """

    def __init__(self, human: Human, sites: tuple[ContactSite, ...], contacts: Contacts):
        self.human, self.sites, self._contacts = human, sites, contacts
        self.nq, self.nv = human.model.nq, human.model.nv
        self.rows: dict[str, list[Any]] = {
            name: [] for name in ("time", "qpos", "qvel", "qacc", "tau", "motor")
        }
        self.taken: list[Taken | None] = []
        self.pushed: list[list[Wrench]] = []
        self.signals: list[dict[str, Any]] = []

    def __len__(self) -> int:
        """Return the number of whole frames."""
        return len(self.signals)

    def before(self, data: mujoco.MjData, time: float) -> None:
        """Keep the state from which a step starts."""
        self._state = time, data.qpos[: self.nq].copy(), data.qvel[: self.nv].copy()

    def after(
        self,
        data: mujoco.MjData,
        taken: Taken | None,
        tau: Float[Array, " n_hinges"],
        motor: Float[Array, " n_hinges"],
        pushed: list[Wrench],
        signals: dict[str, Any],
    ) -> None:
        """Keep the forces and accelerations of that state, which the step has computed."""
        rows = self.rows
        for name, value in zip(("time", "qpos", "qvel"), self._state, strict=True):
            rows[name].append(value)
        rows["qacc"].append(data.qacc[: self.nv].copy())
        rows["tau"].append(tau)
        rows["motor"].append(motor)
        self.taken.append(taken)
        self.pushed.append(pushed)
        self.signals.append(signals)

    def touch(self) -> Touch:
        """Return the forces from outside in all frames."""
        return self._contacts.read(self.taken)

    def cut(self, n: int) -> None:
        """Drop all frames from the ``n``-th on."""
        for kept in (*self.rows.values(), self.taken, self.pushed, self.signals):
            del kept[n:]

    def motion(self, touch: Touch, until: float = np.inf) -> Motion:
        """Return the motion, with the events of feet that strike and leave the ground.

        Args:
            touch: The forces from outside.
            until: There are no events after this time [s].
        """
        if not len(self):
            raise ParameterError("nothing was recorded; step the world first")
        rows = self.rows
        time, force = np.array(rows["time"]), touch.force
        events = []
        for side in SIDES:
            mine = [site.side == side for site in self.sites]
            for contact in contact_events(time, force[:, mine, 2].sum(axis=1)):
                for at, kind in ((contact.start, "heel_strike"), (contact.stop, "toe_off")):
                    if at is not None and at < until:
                        events.append(GaitEvent(float(at), side, kind))
        return Motion(
            time,
            np.array(rows["qpos"]),
            np.array(rows["qvel"]),
            self.human.joint_names,
            qacc=np.array(rows["qacc"]),
            events=tuple(sorted(events, key=lambda e: e.time)),
        )

    def contacts(self, touch: Touch) -> dict[str, Any]:
        """Return sites, forces, points and torques, as a Record takes them.

        Whatever touches another body than a foot, and every push, is a site of its own whose force
        acts where it was applied.
        """
        n, names = len(self), self.human.body_names
        sites = list(self.sites)
        forces, points = [touch.force], [touch.point]
        torques = [np.zeros_like(forces[0])]
        for part, kept in ((TOUCH, touch.others), (PUSH, self.pushes(touch))):
            for body in sorted({w[0] for frame in kept for w in frame}):
                f, p, m = (np.zeros((n, 1, 3)) for _ in range(3))
                for i, frame in enumerate(kept):
                    mine = [w for w in frame if w[0] == body]
                    if mine:
                        f[i, 0], p[i, 0], m[i, 0] = _gathered(mine)
                name = names[body - 1]
                sites.append(
                    ContactSite(body=name, name=f"{part}_{name}", part=part, measured=True)
                )
                forces.append(f)
                points.append(p)
                torques.append(m)
        force, point, torque = (np.concatenate(x, axis=1) for x in (forces, points, torques))
        point[~force.any(axis=2)] = np.nan
        return {
            "sites": tuple(sites),
            "contact_force": force,
            "contact_point": point,
            "contact_torque": torque if torque.any() else None,
        }

    def pushes(self, touch: Touch) -> list[list[Wrench]]:
        """Return what pushed in every frame and is no ground."""
        return [a + b for a, b in zip(self.pushed, touch.things, strict=True)]

    def kept_signals(self) -> dict[str, Array]:
        """Return what controllers said, one row a frame; what was not said there is NaN."""
        names = sorted({name for frame in self.signals for name in frame})
        found = {}
        for name in names:
            values = [np.asarray(f[name], dtype=float) if name in f else None for f in self.signals]
            shape = next(v.shape for v in values if v is not None)
            if any(v is not None and v.shape != shape for v in values):
                raise ParameterError(f"a controller's signal {name!r} changes its shape")
            missing = np.full(shape, np.nan)
            found[name] = np.array([missing if v is None else v for v in values])
        return found


def _gathered(wrenches: list[Wrench]) -> tuple[Array, Array, Array]:
    """Return force, point and free moment of several forces on one body."""
    force = np.sum([f for _, f, _ in wrenches], axis=0)
    load = np.array([np.linalg.norm(f) for _, f, _ in wrenches])
    load = load if load.any() else np.ones(len(load))
    point = load @ np.array([p for _, _, p in wrenches]) / load.sum()
    moment = np.sum([np.cross(p - point, f) for _, f, p in wrenches], axis=0)
    return force, point, moment
