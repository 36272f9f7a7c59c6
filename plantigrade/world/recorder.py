"""Recording of frames while a world is simulated.

Configuration, velocity, acceleration and forces of a frame belong to one instant of the physics, so
the equations of motion hold in it to rounding error.
"""

from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import PUSH_PART, TOUCH_PART, ContactSite
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.plate_events import contact_events
from plantigrade.motion.recording import GaitEvent
from plantigrade.record import Record
from plantigrade.record.moving_ground import MIN_MOVEMENT, MOVED, PLACE
from plantigrade.record.scene_objects import PLACES, object_signals
from plantigrade.world.contacts import Contacts, ExternalForces, StepContacts, Wrench
from plantigrade.world.simulated_world import SimulatedWorld


class Recorder:
    """Records a frame in two calls: :meth:`before` a step of the physics and :meth:`after` it.

    Derived quantities are computed at the end.
    """

    def __init__(self, human: Human, sites: tuple[ContactSite, ...], contacts: Contacts):
        self.human, self.sites, self._contacts = human, sites, contacts
        self.nq, self.nv = human.model.nq, human.model.nv
        self.rows: dict[str, list[Any]] = {
            name: [] for name in ("time", "qpos", "qvel", "qacc", "tau", "motor")
        }
        self.step_contacts: list[StepContacts | None] = []
        self.push_wrenches: list[list[Wrench]] = []
        self.signals: list[dict[str, Any]] = []

    def __len__(self) -> int:
        return len(self.signals)

    def before(self, data: mujoco.MjData, time: float) -> None:
        """Record the state before a step."""
        self._state = time, data.qpos[: self.nq].copy(), data.qvel[: self.nv].copy()

    def after(
        self,
        data: mujoco.MjData,
        step_contacts: StepContacts | None,
        tau: Float[Array, " n_hinges"],
        motor: Float[Array, " n_hinges"],
        push_wrenches: list[Wrench],
        signals: dict[str, Any],
    ) -> None:
        """Record the forces and accelerations of that state, which the step has computed."""
        rows = self.rows
        for name, value in zip(("time", "qpos", "qvel"), self._state, strict=True):
            rows[name].append(value)
        rows["qacc"].append(data.qacc[: self.nv].copy())
        rows["tau"].append(tau)
        rows["motor"].append(motor)
        self.step_contacts.append(step_contacts)
        self.push_wrenches.append(push_wrenches)
        self.signals.append(signals)

    def external_forces(self) -> ExternalForces:
        """Return the external forces in all frames."""
        return self._contacts.external_forces(self.step_contacts)

    def cut(self, n: int) -> None:
        """Drop frame ``n`` and all later ones."""
        for frames in (*self.rows.values(), self.step_contacts, self.push_wrenches, self.signals):
            del frames[n:]

    def motion(self, external: ExternalForces, until: float = np.inf) -> Motion:
        """Return the motion with its heel strikes and toe-offs.

        Args:
            external: External forces in all frames.
            until: Time after which events are ignored [s].
        """
        if not len(self):
            raise ParameterError("nothing was recorded; step the world first")
        rows = self.rows
        time, force = np.array(rows["time"]), external.force
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

    def contacts(self, external: ExternalForces) -> dict[str, Any]:
        """Return sites, forces, points and torques as arguments of a Record.

        Contacts of bodies other than the feet and pushes are contact sites of their own, at the
        point of application.
        """
        n, names = len(self), self.human.body_names
        sites = list(self.sites)
        forces, points = [external.force], [external.point]
        torques = [np.zeros_like(forces[0])]
        for part, frames in ((TOUCH_PART, external.others), (PUSH_PART, self.pushes(external))):
            for body in sorted({w[0] for frame in frames for w in frame}):
                f, p, m = (np.zeros((n, 1, 3)) for _ in range(3))
                for i, frame in enumerate(frames):
                    mine = [w for w in frame if w[0] == body]
                    if mine:
                        f[i, 0], p[i, 0], m[i, 0] = _resultant(mine)
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

    def pushes(self, external: ExternalForces) -> list[list[Wrench]]:
        """Return pushes and forces of scene objects in every frame."""
        return [a + b for a, b in zip(self.push_wrenches, external.objects, strict=True)]

    def signal_arrays(self) -> dict[str, Array]:
        """Return the signals, one row per frame; NaN where a frame has no value."""
        names = sorted({name for frame in self.signals for name in frame})
        found = {}
        for name in names:
            values = [np.asarray(f[name], dtype=float) if name in f else None for f in self.signals]
            shape = next(v.shape for v in values if v is not None)
            if any(v is not None and v.shape != shape for v in values):
                raise ParameterError(f"the controller's signal {name!r} changes its shape")
            missing = np.full(shape, np.nan)
            found[name] = np.array([missing if v is None else v for v in values])
        return found


def _resultant(wrenches: list[Wrench]) -> tuple[Array, Array, Array]:
    """Return force, point and free moment of the resultant of forces on one body."""
    force = np.sum([f for _, f, _ in wrenches], axis=0)
    load = np.array([np.linalg.norm(f) for _, f, _ in wrenches])
    load = load if load.any() else np.ones(len(load))
    point = load @ np.array([p for _, _, p in wrenches]) / load.sum()
    moment = np.sum([np.cross(p - point, f) for _, f, p in wrenches], axis=0)
    return force, point, moment


def record_of(world: SimulatedWorld, recorder: Recorder) -> Record:
    """Return the Record of the frames that a recorder kept.

    Signals: ``world.motor``, torques of the motors alone [N m]; ``world.push``, sum of pushes
    [N]; ``controller.NAME``, signals of the controller; ``things.*``, poses of scene objects.

    Raises:
        ParameterError: If no frame was recorded.
    """
    until = np.inf if world.fall is None else world.fall.time
    external = recorder.external_forces()
    motion = recorder.motion(external, until)
    n, nv = motion.n_frames, world.human.model.nv
    tau = np.zeros((n, nv))
    tau[:, 6:] = recorder.rows["tau"]
    signals: dict[str, Array] = {"world.motor": np.array(recorder.rows["motor"])}
    pushes = np.zeros((n, 3))
    for i, frame in enumerate(recorder.pushes(external)):
        pushes[i] = np.sum([force for _, force, _ in frame], axis=0) if frame else 0.0
    if pushes.any():
        signals["world.push"] = pushes
    signals |= recorder.signal_arrays()
    if PLACES in signals:
        signals |= object_signals(
            [d.scene_object for d in world.disturbances if d.scene_object is not None]
        )
    notes = [] if world.fall is None else [f"The person {world.fall}."]
    if world.diverged is not None:
        notes.append(
            f"The simulation diverged at {world.diverged:.2f} s; the frames before are kept."
        )
    if np.abs(signals.get(PLACE, 0.0)).max() > MIN_MOVEMENT:
        notes.append(MOVED)
    return Record(
        world.human,
        motion,
        qfrc_actuator=tau,
        **recorder.contacts(external),
        ground=world.ground,
        signals=signals,
        notes=tuple(notes),
    )
