"""Postures over feet that are posed, with the centre of mass where it is to be."""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.foot_pose import SEGMENTS, FootPoser
from plantigrade.kinematics.state import State, integrate
from plantigrade.models import Human
from plantigrade.world import standing_on

ROUNDS = 12
"""Gauss-Newton steps for the first frame; each of the others takes three from the one before."""
ANKLE, FOOT, OVER, HIGH, UPRIGHT, JOINT, STILL = 30.0, 10.0, 10.0, 10.0, 2.0, 0.3, 3.0
"""How much the rows of a posture weigh, those of ankles, turn of the feet, centre of mass over the
ground and its height, pelvis upright, joints as in standing, and of no angular momentum, over
body mass [m²/s]."""


class Postures:
    """Postures of one person over feet that are posed."""

    def __init__(self, human: Human):
        self.human, self.posers = human, [FootPoser(human, side) for side in SIDES]
        self.start = standing_on(human, Ground())
        state = State(human, self.start)
        self.over, self.high = state.com[:2], float(state.com[2])
        self.foot = [human.body(f"foot_{side}") for side in SIDES]
        self.ankle = np.array([state.origin(foot) for foot in self.foot])
        self.ankle[:, 2] = [poser.standing for poser in self.posers]
        ahead = [state.rotation(foot)[:2, 0] for foot in self.foot]
        turn = [np.arctan2(y, x) for x, y in ahead]
        self.facing = np.array(
            [[[np.cos(t), -np.sin(t), 0], [np.sin(t), np.cos(t), 0], [0, 0, 1.0]] for t in turn]
        )
        self.hinges = [np.array([human.hinge(c) for c in p.coordinates]) for p in self.posers]
        within = np.zeros(len(human.coordinates), dtype=bool)
        within[np.concatenate(self.hinges)] = True
        self.free = np.flatnonzero(np.concatenate([np.ones(6, bool), ~within]))
        names = [name for name, _, _ in human.contact_points]
        self.order = [np.array([names.index(n) for n in p.spheres]) for p in self.posers]
        self.n_sites = len(names)
        self.side = np.array([name[-1] for name in names])

    def spheres_of(self, marked: Bool[Array, "n 2 n_marks"]) -> Bool[Array, "n n_sites"]:
        """Return which spheres belong to segments that press."""
        on = np.zeros((len(marked), self.n_sites), dtype=bool)
        for k, poser in enumerate(self.posers):
            mine = marked[:, k]
            pressing = mine[:, : len(SEGMENTS)][:, poser.segment]
            edge = np.array(["heel_back" in name for name in poser.spheres])
            tips = np.array(["toe" in name.split("phalanges")[-1] for name in poser.spheres])
            pressing = pressing | (mine[:, [4]] & edge) | (mine[:, [5]] & tips)
            on[:, self.order[k]] = pressing
        return on

    def places(self, ankle: Array, presses: Array, lasting: Array) -> tuple[Array, Array]:
        """Return where spheres are with ankles so far from standing, and which of them last."""
        goal = np.array([[*self.over, self.high + ankle[:, 2].min()]])
        qpos = self.path(ankle[None], presses[None], goal, 0.0)
        state, out = State(self.human, qpos[0]), np.zeros((self.n_sites, 3))
        for i, site in enumerate(contact_sites(self.human)):
            out[i] = state.origin(site.body) + state.rotation(site.body) @ np.array(site.position)
        return out, self.spheres_of(lasting[None])[0]

    def path(
        self,
        ankle: Float[Array, "n 2 3"],
        marked: Bool[Array, "n 2 n_marks"],
        goal: Float[Array, "n 3"],
        still: float,
    ) -> Float[Array, "n nq"]:
        """Return the configuration of every frame.

        Args:
            ankle: How far each ankle is from standing [m].
            marked: Which segments press.
            goal: Where the centre of mass is to be [m].
            still: Frames a second where the body is not to turn; 0 where it may [1/s].
        """
        turns, shifts, qpos = [], [], np.tile(self.start, (len(ankle), 1))
        for k, poser in enumerate(self.posers):
            facing = np.tile(self.facing[k], (len(ankle), 1, 1))
            pose = poser.pose(self.ankle[k] + ankle[:, k], facing, marked[:, k])
            low, high = self.human.limits[:, self.hinges[k]]
            qpos[:, 7 + self.hinges[k]] = np.clip(pose.angles, low, high)
            turns.append(pose.rotation)
            shifts.append(pose.shift)
        state, stands = State(self.human, self.start), np.any(marked, axis=2)
        within = np.concatenate(self.hinges) + 7
        for i, q in enumerate(qpos):
            before = None
            if i:
                fresh, q[:] = q[within].copy(), qpos[i - 1]
                q[within], before = fresh, qpos[i - 1]
            feet = self.ankle + ankle[i]
            feet[:, 2] += [shift[i] for shift in shifts]
            wanted = feet, [t[i] for t in turns], goal[i], stands[i]
            for _ in range(3 if i else ROUNDS):
                state = state.moved_to(q)
                q[:] = self._nearer(state, *wanted, before, still)
        return qpos

    def _nearer(
        self,
        state: State,
        feet: Array,
        turns: list[Array],
        goal: Array,
        stands: Array,
        before: Array | None,
        still: float,
    ) -> Array:
        """Return a configuration nearer to what is wanted, by a Gauss-Newton step."""
        J, _, _ = state.touched(np.array(self.foot), np.array([state.origin(f) for f in self.foot]))
        rows, right = (
            [J.reshape(6, -1) * ANKLE],
            [(feet - [state.origin(f) for f in self.foot]).ravel() * ANKLE],
        )
        for foot, turn, on in zip(self.foot, turns, stands, strict=True):
            if not on:  # a foot in the air hangs as it likes
                continue
            now = state.rotation(foot)
            rows.append(FOOT * state.angular_jacobian(foot))
            right.append(FOOT * 0.5 * np.cross(now, turn, axis=0).sum(axis=1))
        weight = np.array([OVER, OVER, HIGH])
        rows.append(state.com_jacobian * weight[:, None])
        right.append((goal - state.com) * weight)
        if before is not None and still:
            spin = state.angular_momentum_jacobian * (STILL * still / state.mass)
            rows.append(spin)
            right.append(-spin @ state.difference(before))
        back = -state.difference(self.start)
        own = np.concatenate([np.zeros(3), np.full(3, UPRIGHT), np.full(len(back) - 6, JOINT)])
        A, b = np.concatenate(rows)[:, self.free], np.concatenate(right)
        w = own[self.free]
        H = A.T @ A + np.diag(w**2 + 1e-6)
        step = np.zeros(len(back))
        step[self.free] = np.linalg.solve(H, A.T @ b + w**2 * back[self.free])
        q = integrate(state.model, state.qpos, np.clip(step, -0.3, 0.3))
        low, high = self.human.limits
        q[7:] = np.clip(q[7:], low, high)
        return q


def rates_of(human: Human, qpos: Float[Array, "n nq"], rate: float) -> Float[Array, "n nv"]:
    """Return the velocities of configurations, so many of them a second [1/s]."""
    state = State(human, qpos[0])
    steps = np.array(
        [state.moved_to(b).difference(a) for a, b in zip(qpos[:-1], qpos[1:], strict=True)]
    )
    ends = np.vstack([steps[:1], steps, steps[-1:]])
    return rate * 0.5 * (ends[:-1] + ends[1:])
