"""Scripts of foot motions: where the ankles are, which segments press the ground, and when.

A script is a TOML file that anyone can edit (those of :data:`MOTIONS` are in ``motions/``)::

    title = "On tiptoe"

    [[frame]]
    time = 1.5
    both = { presses = ["medial_phalanges", "lateral_phalanges"], ankle = [0.0, 0.0, 0.04] }
    [[frame]]
    time = 6.0

Every frame says where the feet are at a time: ``right``, ``left`` or ``both``, with ``ankle``, how
far the ankle is from where it is in standing, forward, to the left and up, in metres of a person of
1.74 m; and ``presses``, the segments on the ground (names of
:data:`~plantigrade.kinematics.foot_pose.MARKS`), ``[]`` for a foot in the air. What a frame does
not say stays as it was; before the first one the person stands. ``body`` moves the centre of mass
likewise, from where it would be by itself. On the way from one frame to the next those segments
press that do at both ends; where no foot does, the body flies: it leaves and meets the ground with
the speed of a fall of that duration.

The feet are posed by the paper's controller (:mod:`plantigrade.kinematics.foot_pose`), and the body
above them by least squares: joints as in standing, and the centre of mass over what presses now and
next.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance.reference import Followed
from plantigrade.control.balance.support import inside
from plantigrade.errors import ParameterError
from plantigrade.kinematics.foot_pose import MARKS, SEGMENTS, FootPoser, marks
from plantigrade.kinematics.state import State, integrate
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.toml import parse_toml, read_toml
from plantigrade.world import standing_on

MOTIONS = ("tiptoe", "tilt-inside", "tilt-outside", "circling", "one-foot", "jump")
"""Scripts that come with the package."""
HEIGHT = 1.74
"""Stature that lengths in a script are meant for [m]."""
RATE = 50.0
"""Frames of a scripted motion [1/s]."""
LONGEST = 600.0
"""Longest script [s]."""
FARTHEST = 0.5
"""Farthest an ankle or the body may be from where it stands [m]."""
ROUNDS = 12
"""Gauss-Newton steps for the first frame; each of the others takes three from the one before."""
ANKLE, FOOT, OVER, HIGH, UPRIGHT, JOINT = 30.0, 10.0, 10.0, 10.0, 2.0, 0.3
"""How much the rows of a posture weigh, those of ankles, turn of the feet, centre of mass over the
ground and its height, pelvis upright, joints as in standing."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Where the feet are to be at a time.

    Attributes:
        time: When [s].
        ankle: How far each ankle, right first, is from where it is in standing [m].
        presses: Which of :data:`~plantigrade.kinematics.foot_pose.MARKS` press, for each foot.
        body: How far the centre of mass is from where it would be by itself [m].
    """

    time: float
    ankle: Float[Array, "2 3"]
    presses: Bool[Array, "2 n_marks"]
    body: Float[Array, " 3"]


@dataclass(frozen=True, eq=False)
class Script:
    """A script.

    Attributes:
        title: What it is called.
        frames: Its frames, the first at time zero: standing.
    """

    title: str
    frames: tuple[Frame, ...]

    @property
    def duration(self) -> float:
        """When it ends [s]."""
        return self.frames[-1].time


def script_named(word: str) -> Script:
    """Return one of :data:`MOTIONS`, or the script in a TOML file.

    Raises:
        ParameterError: If there is no such script, or it is no script.
    """
    if word in MOTIONS:
        text = files("plantigrade.control.balance").joinpath("motions", f"{word}.toml")
        return _read(Path(str(text)), word)
    if not word.endswith(".toml"):
        raise ParameterError(f"no motion {word!r}; there are {', '.join(MOTIONS)}, or a TOML file")
    return _read(Path(word), word)


def _read(path: Path, name: str) -> Script:
    return _script(parse_toml(read_toml(path), path), name)


def _script(told: Mapping[str, Any], name: str) -> Script:
    if unknown := set(told) - {"title", "frame"}:
        raise ParameterError(
            f"{name} says {', '.join(sorted(unknown))}; it may say title and frame"
        )
    rows = told.get("frame")
    if not isinstance(rows, list) or not rows:
        raise ParameterError(f"{name} has no [[frame]]")
    flat = np.tile(marks(*SEGMENTS), (2, 1))
    frames = [Frame(0.0, np.zeros((2, 3)), flat, np.zeros(3))]
    for i, row in enumerate(rows):
        where = f"{name}, frame {i + 1}"
        if not isinstance(row, Mapping):
            raise ParameterError(f"{where} is no table")
        frames.append(_frame(row, frames[-1], where))
    if frames[-1].time <= 0:
        raise ParameterError(f"{name} ends at {frames[-1].time:g} s")
    return Script(str(told.get("title", name)), tuple(frames))


def _frame(row: Mapping[str, Any], before: Frame, where: str) -> Frame:
    """Return a frame, what it does not say as in the one before."""
    if unknown := set(row) - {"time", "right", "left", "both", "body"}:
        raise ParameterError(f"{where} says {', '.join(sorted(unknown))}")
    time = row.get("time")
    if not isinstance(time, int | float) or not before.time < time <= LONGEST:
        raise ParameterError(
            f"{where}: time={time!r} must be after {before.time:g} s and at most {LONGEST:g} s"
        )
    ankle, presses = before.ankle.copy(), before.presses.copy()
    for word, feet in (("both", (0, 1)), ("right", (0,)), ("left", (1,))):
        told = row.get(word, {})
        if not isinstance(told, Mapping) or set(told) - {"ankle", "presses"}:
            raise ParameterError(f"{where}: {word} may say ankle and presses")
        for foot in feet:
            if "ankle" in told:
                ankle[foot] = _place(told["ankle"], f"{where}: ankle")
            if "presses" in told:
                names = told["presses"]
                if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
                    raise ParameterError(f"{where}: presses is a list of {', '.join(MARKS)}")
                presses[foot] = marks(*names)
    body = _place(row["body"], f"{where}: body") if "body" in row else before.body
    return Frame(float(time), ankle, presses, body)


def _place(told: Any, where: str) -> Array:
    numbers = isinstance(told, list) and all(isinstance(x, int | float) for x in told)
    if not numbers or len(told) != 3 or not np.abs(told).max() <= FARTHEST:
        raise ParameterError(
            f"{where} is three numbers [m], none beyond {FARTHEST:g}, not {told!r}"
        )
    return np.array(told, dtype=float)


def scripted(human: Human, script: Script) -> Followed:
    """Return a script as a motion of a person on level ground.

    Args:
        human: The person; with multi-segment feet.
        script: The script.

    Raises:
        ParameterError: If the feet are of another kind.
    """
    time = np.arange(round(script.duration * RATE) + 1) / RATE
    pose = _Poses(human)
    frames, scale = script.frames, human.height / HEIGHT
    at = np.array([f.time for f in frames])
    segment = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(frames) - 2)
    presses = np.array([f.presses for f in frames])
    way = presses[:-1] & presses[1:]  # from each frame to the next
    flies = np.array([not w.any() for w in way])
    ankle = scale * _path(at, np.array([f.ankle for f in frames]), time, flies, scale)
    body = scale * _path(at, np.array([f.body for f in frames]), time, flies, scale)
    # A frame's own segments press at its time only; the motion is sampled on the way.
    over = _targets(pose, frames, way, scale)
    u = _smooth((time - at[segment]) / np.diff(at)[segment])[:, None]
    target = (1 - u) * over[segment] + u * over[segment + 1]
    marked = way[segment]
    qpos = pose.path(ankle, marked, target, body)
    qvel = _rates(human, qpos)
    motion = Motion(time, qpos, qvel, human.joint_names)
    return Followed(human, motion, pose.spheres_of(marked))


def _smooth(u: Array) -> Array:
    """Return the path of least jerk from 0 to 1."""
    u = np.clip(u, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def _path(at: Array, values: Array, time: Array, flies: Array, scale: float) -> Array:
    """Return values between frames: of least jerk, in flight a parabola, with its speed beside."""
    k = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(at) - 2)
    span = np.diff(at)
    u = _smooth((time - at[k]) / span[k]).reshape(-1, *[1] * (values.ndim - 1))
    out = values[k] + u * np.diff(values, axis=0)[k]
    for i in np.flatnonzero(flies):
        rise = (values[i + 1, ..., 2] - values[i, ..., 2]) / span[i]
        up = rise + 0.5 * GRAVITY / scale * span[i]
        down = up - GRAVITY / scale * span[i]
        own = k == i
        s = (time[own] - at[i]).reshape(-1, *[1] * (values.ndim - 2))
        out[own, ..., 2] = values[i, ..., 2] + up * s - 0.5 * GRAVITY / scale * s**2
        if values.ndim > 2:
            continue  # ankles stand still where they press; only the body has speed there
        for j, first, last in ((i - 1, 0.0, up), (i + 1, down, 0.0)):
            if 0 <= j < len(span):
                own, h = k == j, span[j]
                s = (time[own] - at[j]) / h
                a, b = values[j, 2], values[j + 1, 2]
                out[own, 2] = (
                    (2 * s**3 - 3 * s**2 + 1) * a
                    + (3 * s**2 - 2 * s**3) * b
                    + h * (s**3 - 2 * s**2 + s) * first
                    + h * (s**3 - s**2) * last
                )
    return out


def _rates(human: Human, qpos: Array) -> Array:
    """Return the velocities of a motion sampled at :data:`RATE`."""
    state = State(human, qpos[0])
    steps = np.array(
        [state.moved_to(b).difference(a) for a, b in zip(qpos[:-1], qpos[1:], strict=True)]
    )
    ends = np.vstack([steps[:1], steps, steps[-1:]])
    return RATE * 0.5 * (ends[:-1] + ends[1:])


def _targets(pose: "_Poses", frames: tuple[Frame, ...], way: Array, scale: float) -> Array:
    """Return where the centre of mass is to be at every frame: over what presses before and after.

    Where nothing presses, as over the frame before.
    """
    targets = [pose.over]
    for i, frame in enumerate(frames[1:], start=1):
        lasting = frame.presses & way[i - 1] & way[min(i, len(way) - 1)]
        if not lasting.any():
            lasting = frame.presses
        if not lasting.any():
            targets.append(targets[-1])
            continue
        places, on = pose.places(scale * frame.ankle, frame.presses, lasting)
        targets.append(inside(places[on, :2], pose.over, np.inf))
    return np.array(targets)


class _Poses:
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
        names = [
            f"contact_{site.name}".replace("contact_contact", "contact")
            for site in contact_sites(human)
        ]
        self.order = [np.array([names.index(n) for n in p.spheres]) for p in self.posers]
        self.n_sites = len(names)

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
        qpos = self.path(ankle[None], presses[None], self.over[None], np.zeros((1, 3)))
        state, out = State(self.human, qpos[0]), np.zeros((self.n_sites, 3))
        for i, site in enumerate(contact_sites(self.human)):
            out[i] = state.origin(site.body) + state.rotation(site.body) @ np.array(site.position)
        return out, self.spheres_of(lasting[None])[0]

    def path(self, ankle: Array, marked: Array, over: Array, body: Array) -> Array:
        """Return the configuration of every frame.

        Args:
            ankle: How far each ankle is from standing [m].
            marked: Which segments press.
            over: Where the centre of mass is to be over the ground [m].
            body: How far it is to be from there, and from its own height [m].
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
        for i, q in enumerate(qpos):
            if i:
                within = np.concatenate(self.hinges) + 7
                fresh, q[:] = q[within].copy(), qpos[i - 1]
                q[within] = fresh
            feet = self.ankle + ankle[i]
            feet[:, 2] += [shift[i] for shift in shifts]
            rise = float(feet[:, 2].min() - self.ankle[:, 2].min())
            goal = np.array([*(over[i] + body[i, :2]), self.high + rise + body[i, 2]])
            for _ in range(3 if i else ROUNDS):
                state = state.moved_to(q)
                q[:] = self._nearer(state, feet, [t[i] for t in turns], goal, stands[i])
        return qpos

    def _nearer(self, state, feet: Array, turns: list[Array], goal: Array, stands: Array) -> Array:
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
