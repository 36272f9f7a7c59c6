"""The controller that carries out a motion: reference, planner, whole-body program, world."""

from math import hypot, sqrt

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.replay import tasks
from plantigrade.control.replay.catch import Catch
from plantigrade.control.replay.clearance import clearance_of
from plantigrade.control.replay.edges import on_one_side
from plantigrade.control.replay.gait import JUST, Gait
from plantigrade.control.replay.planner import BACK, LandingBox, Step, decayed, next_step
from plantigrade.control.replay.reference import Instant, Reference, reference_of, world_sites
from plantigrade.control.replay.swing import NARROW
from plantigrade.control.replay.words import replay_figures, steps_told, touchdowns_told
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.record import Record
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.whole_body import Touching, WholeBody
from plantigrade.world import Command, StablePD, State

FASTER = 2.5
"""Rate by which the motion's own velocities are scaled, at most."""
FIRM = 3.0
"""Feedback of the divergent component by the centre of pressure, by its own rate."""
INSIDE = 0.01
"""The centre of pressure stays so far inside of what touches [m]."""
SOFT = 0.012
"""Damping of the joints about the planned velocity, by their strength [s]."""
TOUCHING, PLANNED = 0.002, 0.006
"""Points this near to the ground touch: any of a standing foot, and those planned to [m]."""
VERTICAL = (80.0, 16.0)
"""Stiffness and damping of the height of the centre of mass, by mass [1/s², 1/s]."""
HEIGHTS = (-7.0, 12.0)
"""Limits of its vertical acceleration [m/s²]."""
BACK_UP = (-3.0, 8.0)
"""Limits of the part of it that leads back to the motion: who falls cannot press [m/s²]."""
RETURN, RETURNING, FAR = 0.2, 0.06, 0.12
"""The path that is walked is led back to the planned one: at this rate [1/s] and speed at most
[m/s]; the person is taken to be off it by so much at most [m]."""
HURRIED, MISSED = 0.75, (0.04, 0.16)
"""With both feet on the ground the phase runs so much faster where the divergent component is
missed by that much: not at all, and fully [m]."""
AGAIN = 0.35
"""So long after a step the next one can land [s]."""
BOUNCE = 1.2
"""Rate by which the height's own acceleration is scaled, at most."""
OVERLAP = 0.002
"""Legs that overlap more than this in the motion are told of [m]."""
AXES = np.arange(3)
SEAT = len(SIDES)
"""Among the sides: what is on no foot."""
GRIP = 0.75
"""Part of the friction that is counted on."""


class Replay:
    """Carry out a whole motion and stay on the feet.

    Args:
        record: The motion, with its forces and torques where it has them.

    Attributes:
        rate: Steps of the physics per second that it wants [1/s].
        control_rate: Commands per second that it wants [1/s].
        record_rate: Frames per second that are enough [1/s].
    """

    rate, control_rate, record_rate = 1000.0, 500.0, 100.0

    def __init__(self, record: Record):
        self.record, self.human, self.ground = record, record.human, record.ground
        self.clearance = clearance_of(record)
        self.reference: Reference = reference_of(record, self.clearance)
        human, self.sites = self.human, world_sites(record)
        self.points = PointSet.of(human, self.sites)
        self.radius = np.array([[s.radius] for s in self.sites])
        self.side_of = np.array([(*SIDES, "").index(s.side) for s in self.sites])
        self.of_side = [(self.side_of == i).nonzero()[0] for i in range(SEAT + 1)]
        self.seated = np.array([not s.side for s in self.reference.schedule.stances], float)
        self.normal = self.ground.normal
        self.normals = np.tile(self.normal, (len(self.points), 1))
        self.feet = PointSet(human, [f"foot_{s}" for s in SIDES], np.zeros((2, 3)))
        self.weights = tasks.Weights.of(human)
        low, high = np.array(human.model.jnt_actfrcrange[1:]).T
        self.damping = SOFT * np.maximum(-low, high)
        self.body = BodyState(human, human.standing())
        hip = self.body.origin(f"femur_{SIDES[0]}")
        self.leg = float(hip[2] - self.body.origin(f"foot_{SIDES[0]}")[2])
        self.gravity = np.array(human.model.opt.gravity)
        self.friction = GRIP * self.ground.friction
        self.program: WholeBody | None = None
        self.gait = Gait(self.reference, record.weight)
        self.off: Array = np.zeros(2)
        self.path, self.error = np.zeros(2), np.zeros(2)
        self.catch = Catch(self.leg, self.record.weight)
        self.grows = float(np.exp(self.reference.omega * AGAIN))
        self._kept: tuple[float, Instant | None] = (np.nan, None)

    def __call__(self, state: State) -> Command:
        """Return what the joints are to do for one control step."""
        world = state.world
        if self.program is None or state.time == 0.0:
            self._begin(state)
        step = self.step = 1.0 / world.control_rate
        gait, reference = self.gait, self.reference
        body = self.body = self.body.moved_to(state.qpos, state.qvel)
        foot = body.position(self.feet)
        low = body.position(self.points) - self.radius * self.normal
        load = self._loads(state)
        ref = reference.at(gait.phase)
        height = low @ self.normal - self.ground.under(low)
        height[self.of_side[SEAT]] = 0.0
        beside = foot - ref["foot"]
        for i in (0, 1):
            beside[i, 2] = height[self.of_side[i]].min()
        gait.look(state.time, step, load, beside, heading(ref["q"][3:7]))
        if self.catch.waits:
            plan, ref = None, ref.still()
            self._balance(body, ref)
        else:
            self._return(body, ref)
            plan = self._plan(body, ref, foot)
        self._catch(state.time, body, ref, low, height, load)
        if self.catch.waits:
            gait.rate, ref = 0.0, ref.still()
        else:
            gait.advance(state.time, step, self._hurried() if plan is None else plan.rate)
            ref = reference.at(gait.phase)
        return self._command(state, body, ref, plan, low, height, foot, step)

    def said(self) -> tuple[str, ...]:
        """Return what it did in the last simulation, one sentence each."""
        told = [*steps_told(self.gait.touchdowns), touchdowns_told(self.gait.touchdowns)]
        apart = np.rad2deg(self.clearance.abduction)
        if apart.any():
            told.append(
                f"The motion has its arms up to {1e3 * self.clearance.arms:.0f} mm in the body; "
                f"they were held out by {apart[0]:.0f}° on the right and {apart[1]:.0f}° on the "
                "left."
            )
        if self.clearance.legs > OVERLAP:
            told.append(
                f"The motion has one leg up to {1e3 * self.clearance.legs:.0f} mm in the other; "
                "the swinging foot was led past it."
            )
        return tuple(each for each in told if each)

    def figures(self) -> dict[str, float | int]:
        """Return figures of the last simulation."""
        apart = float(np.linalg.norm(self.off)) if len(self.off) else 0.0
        return {**replay_figures(self.gait.touchdowns), "off_path_end_m": apart}

    def _begin(self, state: State) -> None:
        """Start anew."""
        world = state.world
        if world.human.model.nv != self.human.model.nv:
            raise ParameterError(
                f"the motion is of a person with {self.human.model.nv} degrees of freedom; the one "
                f"in the world has {world.human.model.nv}"
            )
        self.gait = Gait(self.reference, self.record.weight)
        self.path, self.error = np.zeros(2), np.zeros(2)
        self.catch = Catch(self.leg, self.record.weight)
        self.grows = float(np.exp(self.reference.omega * AGAIN))
        self.program = WholeBody(self.human, armature=world.actuators.armature)
        self.side_of_geom = np.append(self.side_of, -1)[world.contacts.site_of]

    def _loads(self, state: State) -> Float[Array, " 2"]:
        """Return what each foot carries along the normal, in a step of the physics [N]."""
        contact = state.world.data.contact
        owner = self.side_of_geom[contact.geom]
        which = ((owner.max(axis=1) >= 0) & (contact.efc_address >= 0)).nonzero()[0]
        local = state.world.data.efc_force[contact.efc_address[which][:, None] + AXES]
        along = contact.frame[which].reshape(-1, 3, 3) @ self.normal
        push = (local * along).sum(axis=1)
        push[owner[which, 1] < 0] *= -1.0  # the force is that on the second geom
        return np.bincount(owner[which].max(axis=1), push, SEAT + 1)[:SEAT]

    def _balance(self, body: BodyState, ref: Instant) -> None:
        """Find out how far the divergent component is from rest."""
        first, alpha, _ = self.reference.schedule.weights(self.gait.phase)
        own = [f.number - first for f in self.gait.standing if f.number is not None]
        share = np.zeros(len(alpha))
        share[own] = np.maximum(alpha[own], 1e-3)
        self.shift = share @ self.gait.offsets(first, len(alpha)) / share.sum()
        self.xi = (body.com + body.com_velocity / self.reference.omega)[:2]
        self.deviation = self.xi - ref["com"][:2]
        self.error = self.deviation - self.shift[:2]

    def _catch(self, time: float, body: BodyState, ref, low: Array, height: Array, load) -> None:
        """Take a step that the motion does not have, where nothing else helps."""
        seat = float(self.reference.schedule.weights(self.gait.phase)[1] @ self.seated)
        if seat > 0.0 and not self.catch.waits:
            return
        feet = [low[self.of_side[i]] for i in (0, 1)]
        gaps = [height[self.of_side[i]] for i in (0, 1)]
        missed, ahead = hypot(*self.error), heading(ref["q"][3:7])[:, 0]
        self.catch.look(time, self.step, self.gait, body, feet, gaps, ahead, load, missed)

    def _return(self, body: BodyState, ref: Instant) -> None:
        """Move the path that is walked back to the planned one, slowly."""
        off = (body.com - ref["com"])[:2]
        size = hypot(*off)
        self.path = self.path - self.step * off * min(RETURN, RETURNING / max(size, 1e-9))
        away = off - self.path
        far = hypot(*away)
        if far > FAR:
            self.path = self.path + away * (1.0 - FAR / far)

    def _hurried(self) -> float:
        """Return the rate at which the weight goes over to the other foot."""
        far = hypot(*self.error)
        if far < MISSED[0] or self.reference.schedule.after("r", self.gait.phase) is None:
            return 1.0
        return 1.0 + HURRIED * min((far - MISSED[0]) / (MISSED[1] - MISSED[0]), 1.0)

    def _plan(self, body: BodyState, ref: Instant, places: Array) -> Step | None:
        """Return where and when the swinging foot lands; None where no single foot swings."""
        gait, reference = self.gait, self.reference
        omega = reference.omega
        self.xi = (body.com + body.com_velocity / omega)[:2]
        xi_ref = (ref["com"] + ref["com_velocity"] / omega)[:2]
        self.deviation = self.xi - xi_ref
        first, alpha, beta = reference.schedule.weights(gait.phase)
        standing = gait.standing
        own = [f.number - first for f in standing if f.number is not None]
        offsets = gait.offsets(first, len(alpha))
        share = np.zeros(len(alpha))
        share[own] = alpha[own]
        if share.sum() < 1e-6:
            share[own] = 1.0
        self.shift = share @ offsets / max(share.sum() + alpha @ self.seated, 1e-9)
        swinging = [f for f in gait.feet if not f.stands and f.number is not None]
        if len(standing) != 1 or len(swinging) != 1:
            if not standing:
                for f in swinging:
                    f.swing.lead(self.deviation, f.touchdown - gait.phase, self.step)
                self.error = np.zeros(2)
                return None
            last = max((f.number for f in standing if f.number is not None), default=first)
            known = np.arange(first, first + len(beta)) <= last
            later = decayed(beta[~known], BACK) * BACK
            rest = float(beta[~known].sum())
            newest = gait.offset(last)[:2]
            coming = rest * self.path + later * (newest - self.path)
            self.error = self.deviation - beta[known] @ offsets[known, :2] - coming
            return None
        foot, other = swinging[0], standing[0]
        assert foot.number is not None and other.number is not None
        left = max(foot.touchdown - gait.phase, 0.01)
        then = self._then(foot.touchdown)
        head, _, weights = reference.schedule.weights(foot.touchdown)
        before = np.arange(head, head + len(weights)) < foot.number
        at_other = gait.offsets(head, len(weights))[:, :2]
        later = decayed(weights[~before])
        stays = float(weights[before].sum())
        other_offset = gait.offset(other.number)[:2]
        kept = weights[before] @ at_other[before] / stays if stays > 1e-9 else other_offset
        axes = heading(then["q"][3:7])
        i, k = SIDES.index(foot.side), SIDES.index(other.side)
        nominal = then["foot"][i, :2] - then["foot"][k, :2] - other_offset
        side = foot.left
        apart = side * float((then["foot"][i, :2] - then["foot"][k, :2]) @ axes[:, 1])
        narrowest = min(NARROW * self.leg, apart)
        path = self.path
        here = places[i, :2] - then["foot"][i, :2] - path
        box = LandingBox(axes, nominal + path, side, self.leg, narrowest, here)
        step = next_step(
            self.xi - path,
            xi_ref,
            (then["com"] + then["com_velocity"] / omega)[:2],
            omega,
            left,
            self.shift[:2] - path,
            kept - path,
            stays,
            later,
            box,
            grows=self.grows,
        )
        grown = np.exp(-omega * left / step.rate)
        self.error = grown * later * (step.free - BACK * (self.shift[:2] - path))
        rate = max(gait.rate, 0.2)
        landing = step.offset + path
        if self.ground.steps:
            low = then["low"][self.side_of == i]
            landing = on_one_side(self.ground, low, landing, axes[:, 0])
        foot.swing.lead(landing, left / rate, self.step)
        self.axes, self.swing_side = axes, side
        return step

    def _then(self, phase: float) -> Instant:
        """Return the motion at a touchdown, which is asked for at every tick until then."""
        when, kept = self._kept
        if kept is None or when != phase:
            kept = self.reference.at(phase)
            self._kept = (phase, kept)
        return kept

    def _command(self, state, body, ref, plan, low, height, foot, step) -> Command:
        """Return the command of the whole-body program."""
        gait, reference, normal = self.gait, self.reference, self.normal
        qpos, qvel = state.qpos, state.qvel
        rate = min(gait.rate, FASTER)
        on = ref["on"] > 0.5
        for i, own in enumerate(gait.feet):
            if own.early:
                just = reference.at(own.touchdown + JUST)
                on[self.side_of == i] = just["on"][self.side_of == i] > 0.5
        gap = height - self._lifted()
        active, held = self._touching(on, gap)
        points = body.rigid_points(self.points.body[active], low[active])
        wanted = tasks.wanted_accelerations(ref, rate, qpos, qvel)
        centre = self._com_acceleration(body, ref, rate, low, active)
        M, h = body.mass_matrix, body.bias
        rows: list[Rows | PointRows] = [tasks.com_rows(M, h, self.human.mass, self.gravity, centre)]
        Jf, speed_f, bias_f = (
            f(self.feet) for f in (body.jacobian, body.velocity, body.bias_acceleration)
        )
        hanging = self.side_of[on & (gap > PLANNED)]
        for i, own in enumerate(gait.feet):
            name = f"foot_{own.side}"
            at = int(self.feet.body[i])
            Jr, Br = body.angular_jacobian(at), body.angular_bias_acceleration(name)
            error = tasks.turn_error(ref["turn"][i], body.rotation(at).ravel())
            spin = Jr @ qvel
            goal, speed = rate**2 * ref["turn_acceleration"][i], rate * ref["turn_velocity"][i]
            planes = normal if own.stands else None
            hangs = bool((hanging == i).any())
            rows.append(
                tasks.turn_rows(Jr, Br, goal, error, speed - spin, normal=planes, hangs=hangs)
            )
            if not own.stands:
                place, pace, push = self._swing(own, i, ref, rate, foot, state.time)
                rows.append(
                    tasks.place_rows(Jf[i], bias_f[i], push, place - foot[i], pace - speed_f[i])
                )
        if held.any():
            rows.append(tasks.held_rows(points, held, gap[active], normal))
        touching = Touching(
            self.points.body[active],
            low[active],
            self.normals[: len(active)],
            self.friction,
        )
        weight = np.where(held, tasks.PLANNED, tasks.UNPLANNED) ** 2
        goal = np.where(held[:, None], ref["force"][active], 0.0)
        data = state.world.data
        passive = (data.qfrc_passive + data.qfrc_applied)[6 : 6 + len(self.damping)]
        assert self.program is not None
        answer = self.program.solve(
            body,
            touching,
            rows,
            wanted=wanted,
            weight=self.weights.posture,
            force=goal,
            force_weight=weight,
            torque=ref["tau"] - passive,
            torque_weight=self.weights.torque,
            passive=passive,
            points=points,
        )
        ahead = 0.5 * (step + 1.0 / state.world.rate)
        apart = state.angles - ref["q"][7:]
        self.off = (body.com - ref["com"])[:2]
        return StablePD(
            state.angles,
            qvel[6:] + ahead * answer.qacc[6:],
            torque=answer.torque,
            stiffness=0.0,
            damping=self.damping,
            signals={
                "tracking_error": sqrt(apart @ apart / len(apart)),
                "phase": gait.phase,
                "phase_rate": gait.rate,
                "off_path": self.off,
                "solved": float(answer.ok),
            },
        )

    def _touching(self, on: Array, gap: Array) -> tuple[Array, Array]:
        """Return which points touch, and which of them are held."""
        gait = self.gait
        stands = np.array([*(f.stands for f in gait.feet), True])[self.side_of]
        planned = on & stands & (gap < PLANNED)
        touching = planned | (stands & (gap < TOUCHING) & (self.side_of != SEAT))
        active = touching.nonzero()[0]
        return active, planned[active]

    def _lifted(self) -> Array:
        """Return how much higher the ground is under each point than planned [m]."""
        found = [
            0.0 if f.number is None or not f.stands else self.gait.offset(f.number)[2]
            for f in self.gait.feet
        ]
        return np.array([*found, 0.0])[self.side_of]

    def _com_acceleration(self, body, ref, rate, low, active) -> Array:
        """Return the acceleration of the centre of mass that is wanted."""
        omega = self.reference.omega
        moved = self.shift[:2] + (1.0 + FIRM / omega) * self.error
        if len(active):
            moved = self._inside(ref["pressure"][:2], moved, low[active, :2])
        c, v = body.com, body.com_velocity
        wanted = np.array(ref["com_acceleration"])
        wanted[:2] += omega**2 * ((c - ref["com"])[:2] - moved)
        k, d = VERTICAL
        rate = min(rate, BOUNCE)
        dz = ref["com"][2] + self.shift[2] + self._rise(self.shift) - self.catch.bent - c[2]
        back = k * dz + d * (rate * ref["com_velocity"][2] - v[2])
        up = rate**2 * ref["com_acceleration"][2] + min(max(back, BACK_UP[0]), BACK_UP[1])
        wanted[2] = min(max(up, HEIGHTS[0]), HEIGHTS[1])
        return wanted

    def _rise(self, moved: Array) -> float:
        """Return how much higher the slope is a step away [m]."""
        n = self.normal
        return float(-(n[0] * moved[0] + n[1] * moved[1]) / n[2])

    def _inside(self, pressure: Array, moved: Array, places: Array) -> Array:
        """Return a shift of the centre of pressure that stays among what touches."""
        wanted = pressure + moved
        low, high = places.min(axis=0) + INSIDE, places.max(axis=0) - INSIDE
        nominal = pressure + self.shift[:2]
        low, high = np.minimum(low, nominal), np.maximum(high, nominal)
        return np.minimum(np.maximum(wanted, low), high) - pressure

    def _swing(
        self, own, i: int, ref, rate: float, foot, time: float
    ) -> tuple[Array, Array, Array]:
        """Return place, velocity and acceleration that a swinging foot is to have."""
        place = np.array(ref["foot"][i])
        pace, push = rate * ref["foot_velocity"][i], rate**2 * ref["foot_acceleration"][i]
        others = self.gait.standing
        if others:
            k = SIDES.index(others[0].side)
            axes = heading(ref["q"][3:7])
            planned = (ref["foot"][i] - ref["foot"][k])[:2]
            off = ref["foot"][i, :2] - foot[k, :2]
            own.swing.pass_beside(off, planned, axes, own.left, self.leg, self.clearance.legs)
        moved = own.swing.offset
        level = self.ground.under(place)
        place[:2] += moved
        pace[:2] += own.swing.velocity
        push[:2] += own.swing.acceleration
        place[2] += self._rise(moved)
        if not self.ground.steps:
            place[2] += float(self.ground.under(place) - level)
        if own.caught:
            high, pace[2] = self.catch.height(time)
            place[2] += high
        elif own.lowered:
            place[2] -= own.lowered
            pace[2] = -0.4
        return place, pace, push


def heading(quat: Float[Array, " 4"]) -> Float[Array, "2 2"]:
    """Return the horizontal directions ahead and to the left of a pelvis, as columns."""
    w, x, y, z = quat.tolist()
    ahead, left = w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z)
    size = max(hypot(ahead, left), 1e-9)
    c, s = ahead / size, left / size
    return np.array([[c, -s], [s, c]])
