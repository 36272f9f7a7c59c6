"""Initial standing posture: feet on the ground, centre of mass over the feet."""

from collections.abc import Mapping

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import GEOM, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet, State, integrate
from plantigrade.models import Human

LEG = ("hip_", "knee_angle", "ankle_angle", "subtalar_angle")
WITHIN = ("mtp", "cuboid", "heel")
"""What the names of the hinges begin with that bend on uneven ground: legs, and within the feet."""
PRESSURE = 0.45
"""Where people carry their weight in quiet standing, from the heel, of the length of the foot."""


def standing_on(
    human: Human,
    ground: Ground,
    *,
    ahead: float = PRESSURE,
    width: float | None = None,
    bent: Mapping[str, float] | None = None,
    place: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Float[Array, " nq"]:
    """Return quiet standing: upright, soles along the ground, the centre of mass over the feet.

    The body leans about the ankles until its centre of mass is over its place between the feet,
    and its soles are laid on the ground there (:func:`laid`).

    Args:
        human: The person.
        ground: What they stand on.
        ahead: That place, before the heels, of the length of the soles: by default some 5 cm
            before the ankles.
        width: Distance of the ankles; that of the hips if absent [m].
        bent: Joints of both sides that are bent besides, by name without side [rad]; together
            they leave the soles along the ground, but for a lean of the whole body.
        place: Where they stand: forward and left [m], and how far they are turned to the left
            [rad].

    Raises:
        ParameterError: If the stance is not over the feet, or the feet cannot be there.
    """
    if not 0.0 <= ahead <= 1.0:
        raise ParameterError(
            f"ahead={ahead:g} is not over the soles (0 at the heels, 1 at the toes)"
        )
    upright = human.standing() if width is None else _astride(human, width)
    for name, angle in (bent or {}).items():
        upright[[7 + human.hinge(f"{name}_{side}") for side in SIDES]] += angle
    sites = contact_sites(human)
    lean, slope = 0.0, ground.slope * float(np.cos(place[2]))
    for _ in range(5):
        qpos = _leaning(human, upright, lean, slope)
        data = _placed(human, qpos)
        x = np.array([data.geom(GEOM + s.name).xpos[0] for s in sites])
        wanted = x.min() + ahead * np.ptp(x)
        ankle = float(np.mean([data.body(f"foot_{s}").xpos[2] for s in SIDES]))
        lean += float(wanted - data.subtree_com[1, 0]) / float(data.subtree_com[1, 2] - ankle)
    qpos = moved(_leaning(human, upright, lean, slope), place)
    if ground.uneven or slope != ground.slope:
        return laid(human, ground, qpos)
    return on_ground(human, ground, qpos)


def laid(human: Human, ground: Ground, qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a posture of standing on both feet, with the soles placed on a ground.

    Legs bend, ankles and joints within the feet turn until the soles lie on it as closely as they
    can: least squares of the gaps under them. Pelvis and trunk stay as they are, the feet and the
    centre of mass where they are over the ground.

    Args:
        human: The person.
        ground: What they stand on.
        qpos: How they stand, on ground that may be another one.
    """
    flat = on_ground(human, ground, qpos)
    hinges = [i for i, c in enumerate(human.coordinates) if c.startswith((*LEG, *WITHIN))]
    free = [0, 1, 2, *(6 + i for i in hinges)]
    stiff = [0.05 if human.coordinates[i].startswith(WITHIN) else 0.02 for i in hinges]
    sites = contact_sites(human)
    spheres = PointSet.of(human, sites)
    ankles = PointSet(human, [f"foot_{side}" for side in SIDES], np.zeros((2, 3)))
    radius = np.array([[s.radius] for s in sites])
    first = State(human, flat)
    state = first
    for _ in range(30):
        normal = ground.normal_at(state.position(spheres))
        low = state.position(spheres) - radius * normal
        gap = (low @ ground.normal - ground.under(low)) * (normal @ ground.normal)
        away = (first.position(ankles) - state.position(ankles))[:, :2].ravel()
        turned = [
            0.5 * np.cross(state.rotation(f).T, first.rotation(f).T).sum(axis=0)[2]
            for f in (f"foot_{side}" for side in SIDES)
        ]
        yaw = np.array([state.angular_jacobian(f"foot_{side}")[2] for side in SIDES])
        rows = np.vstack(
            [
                np.einsum("kc,kcv->kv", normal, state.jacobian(spheres)),
                0.5 * state.jacobian(ankles)[:, :2].reshape(4, -1),
                0.1 * yaw,
                state.com_jacobian[:2],
            ]
        )[:, free]
        rest = np.array(stiff) * (flat[7:] - state.qpos[7:])[hinges]
        values = np.r_[-gap, 0.5 * away, 0.1 * np.array(turned), (first.com - state.com)[:2], rest]
        held = np.zeros((len(hinges), len(free)))
        held[:, 3:] = np.diag(stiff)
        step = np.zeros(human.model.nv)
        step[free] = np.linalg.lstsq(np.vstack([rows, held]), values, rcond=None)[0]
        qpos = integrate(human.model, state.qpos, np.clip(step, -0.2, 0.2))
        qpos[7:] = np.clip(qpos[7:], *human.limits)
        state = State(human, qpos)
    return on_ground(human, ground, np.array(state.qpos))


def moved(qpos: Float[Array, " nq"], place: tuple[float, float, float]) -> Float[Array, " nq"]:
    """Return a configuration at another place [m], turned about the vertical of the start [rad]."""
    x, y, turn = place
    c, s = np.cos(turn), np.sin(turn)
    there = qpos.copy()
    there[:2] = [x + c * qpos[0] - s * qpos[1], y + s * qpos[0] + c * qpos[1]]
    about = np.array([np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)])
    mujoco.mju_mulQuat(there[3:7], about, qpos[3:7])
    return there


def _astride(human: Human, width: float) -> Float[Array, " nq"]:
    """Return quiet standing with the ankles so far apart, soles level and feet straight ahead.

    Raises:
        ParameterError: If that is out of reach.
    """
    state = State(human, human.standing())
    names = [f"foot_{side}" for side in SIDES]
    points = PointSet(human, names, np.zeros((2, 3)))
    places, turn = state.position(points).copy(), state.rotation(names[0])
    places[:, 1] = [-width / 2, width / 2]
    stems = ("hip", "ankle", "subtalar")
    free = [2, *(6 + i for i, c in enumerate(human.coordinates) if c.startswith(stems))]
    for _ in range(20):
        off = [places[k] - state.position(points)[k] for k in range(2)]
        off += [0.5 * np.cross(state.rotation(name).T, turn.T).sum(axis=0) for name in names]
        J = [*state.jacobian(points), *(state.angular_jacobian(name) for name in names)]
        rows = np.vstack([np.vstack(J)[:, free], 1e-4 * np.eye(len(free))])
        step = np.zeros(human.model.nv)
        step[free] = np.linalg.lstsq(rows, np.r_[np.concatenate(off), 0 * rows[12:, 0]])[0]
        state = State(human, integrate(human.model, state.qpos, step))
    if not (np.linalg.norm(np.concatenate(off)) < 0.02 and 0.0 < width):
        raise ParameterError(f"feet cannot stand level with their ankles {width:g} m apart")
    return np.array(state.qpos)


def on_ground(human: Human, ground: Ground, qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a configuration raised or lowered until its lowest contact sphere just touches.

    Raises:
        ParameterError: If it is no configuration of this person.
    """
    if qpos.shape != (human.model.nq,) or not np.isfinite(qpos).all():
        raise ParameterError(f"a configuration of this person has {human.model.nq} finite numbers")
    data = _placed(human, qpos)
    sites = contact_sites(human)
    centre = np.array([data.geom(GEOM + s.name).xpos for s in sites])
    radius = np.array([[s.radius] for s in sites])
    normal = ground.normal_at(centre)
    low = centre - radius * normal
    gap = low @ ground.normal - ground.under(low)
    raised = qpos.copy()
    raised[2] -= gap.min() / ground.normal[2]
    return raised


def _leaning(
    human: Human, upright: Float[Array, " nq"], lean: float, slope: float
) -> Float[Array, " nq"]:
    """Return a standing person turned forward about the ankles, feet turned with the ground."""
    qpos = upright.copy()
    qpos[3:7] = [np.cos(lean / 2), 0.0, np.sin(lean / 2), 0.0]
    for side in SIDES:
        qpos[7 + human.hinge(f"ankle_angle_{side}")] += lean + slope
    return qpos


def _placed(human: Human, qpos: Float[Array, " nq"]) -> mujoco.MjData:
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(human.model, data)
    mujoco.mj_comPos(human.model, data)
    return data
