"""Initial standing posture: feet on the ground, centre of mass over the feet."""

from collections.abc import Mapping

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import GEOM_PREFIX, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet, integrate
from plantigrade.models import Human
from plantigrade.spatial.conventions import about_vertical, turned

LEG_COORDINATES = ("hip_", "knee_angle", "ankle_angle", "subtalar_angle")
FOOT_COORDINATES = ("mtp", "cuboid", "heel")
"""Prefixes of the coordinates that adapt to uneven ground, of the legs and within the feet."""
COM_ALONG_SOLE = 0.45
"""Position of the centre of mass in quiet standing, from the heel, as a fraction of foot length."""


def standing_on(
    human: Human,
    ground: Ground,
    *,
    com_along_sole: float = COM_ALONG_SOLE,
    width: float | None = None,
    flexion: Mapping[str, float] | None = None,
    placement: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Float[Array, " nq"]:
    """Return quiet standing: upright, soles along the ground, the centre of mass over the feet.

    The body leans about the ankles until its centre of mass is above the given point of the soles.
    Then the soles are fitted to the ground (:func:`fit_soles`).

    Args:
        com_along_sole: Position of the centre of mass between heels (0) and toes (1), as a fraction
            of sole length; the default is about 5 cm in front of the ankles.
        width: Distance between the ankles; that between the hips if absent [m].
        flexion: Additional joint angles of both sides, by name without side [rad]. Together they
            keep the soles parallel to the ground, apart from a lean of the whole body.
        placement: Position forward and left [m] and heading, positive to the left [rad].

    Raises:
        ParameterError: If the centre of mass is not above the soles, or the feet are out of reach.
    """
    if not 0.0 <= com_along_sole <= 1.0:
        raise ParameterError(
            f"com_along_sole={com_along_sole:g} must be from 0 (heels) to 1 (toes)"
        )
    upright = human.standing() if width is None else _apart(human, width)
    for name, angle in (flexion or {}).items():
        upright[[7 + human.hinge(f"{name}_{side}") for side in SIDES]] += angle
    sites = contact_sites(human)
    tilt, slope = 0.0, ground.slope * float(np.cos(placement[2]))
    for _ in range(5):
        qpos = _leaning(human, upright, tilt, slope)
        data = _kinematics(human, qpos)
        x = np.array([data.geom(GEOM_PREFIX + s.name).xpos[0] for s in sites])
        desired = x.min() + com_along_sole * np.ptp(x)
        ankle = float(np.mean([data.body(f"foot_{s}").xpos[2] for s in SIDES]))
        tilt += float(desired - data.subtree_com[1, 0]) / float(data.subtree_com[1, 2] - ankle)
    qpos = at_placement(_leaning(human, upright, tilt, slope), placement)
    if ground.uneven or slope != ground.slope:
        return fit_soles(human, ground, qpos)
    return on_ground(human, ground, qpos)


def fit_soles(human: Human, ground: Ground, qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a standing posture with both soles fitted to the ground.

    Legs, ankles and joints within the feet are adjusted by least squares of the gaps between soles
    and ground. Pelvis and trunk keep their posture; feet and centre of mass keep their horizontal
    position.

    Args:
        qpos: Standing posture, which may belong to another ground.
    """
    flat = on_ground(human, ground, qpos)
    hinges = [
        i
        for i, c in enumerate(human.coordinates)
        if c.startswith((*LEG_COORDINATES, *FOOT_COORDINATES))
    ]
    free = [0, 1, 2, *(6 + i for i in hinges)]
    stiff = [0.05 if human.coordinates[i].startswith(FOOT_COORDINATES) else 0.02 for i in hinges]
    sites = contact_sites(human)
    spheres = PointSet.of(human, sites)
    ankles = PointSet(human, [f"foot_{side}" for side in SIDES], np.zeros((2, 3)))
    radius = np.array([[s.radius] for s in sites])
    first = BodyState(human, flat)
    state = first
    for _ in range(30):
        normal = ground.normal_at(state.position(spheres))
        sole = state.position(spheres) - radius * normal
        gap = ground.gap(sole) * (normal @ ground.normal)
        ankle_error = (first.position(ankles) - state.position(ankles))[:, :2].ravel()
        yaw_error = [
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
        values = np.r_[
            -gap, 0.5 * ankle_error, 0.1 * np.array(yaw_error), (first.com - state.com)[:2], rest
        ]
        regularisation = np.zeros((len(hinges), len(free)))
        regularisation[:, 3:] = np.diag(stiff)
        step = np.zeros(human.model.nv)
        step[free] = np.linalg.lstsq(np.vstack([rows, regularisation]), values, rcond=None)[0]
        qpos = integrate(human.model, state.qpos, np.clip(step, -0.2, 0.2))
        qpos[7:] = np.clip(qpos[7:], *human.limits)
        state = BodyState(human, qpos)
    return on_ground(human, ground, np.array(state.qpos))


def at_placement(
    qpos: Float[Array, " nq"], placement: tuple[float, float, float]
) -> Float[Array, " nq"]:
    """Return a configuration moved to a placement: forward, left [m] and heading [rad]."""
    x, y, turn = placement
    there = qpos.copy()
    there[:2] = [x, y] + about_vertical(turn)[:2, :2] @ qpos[:2]
    there[3:7] = turned(qpos[3:7], turn)
    return there


def _apart(human: Human, width: float) -> Float[Array, " nq"]:
    """Return quiet standing with a given distance between the ankles, soles level, feet forward."""
    state = BodyState(human, human.standing())
    names = [f"foot_{side}" for side in SIDES]
    points = PointSet(human, names, np.zeros((2, 3)))
    places, turn = state.position(points).copy(), state.rotation(names[0])
    places[:, 1] = [-width / 2, width / 2]
    stems = ("hip", "ankle", "subtalar")
    free = [2, *(6 + i for i, c in enumerate(human.coordinates) if c.startswith(stems))]
    for _ in range(20):
        error = [places[k] - state.position(points)[k] for k in range(2)]
        error += [0.5 * np.cross(state.rotation(name).T, turn.T).sum(axis=0) for name in names]
        J = [*state.jacobian(points), *(state.angular_jacobian(name) for name in names)]
        rows = np.vstack([np.vstack(J)[:, free], 1e-4 * np.eye(len(free))])
        step = np.zeros(human.model.nv)
        step[free] = np.linalg.lstsq(rows, np.r_[np.concatenate(error), 0 * rows[12:, 0]])[0]
        state = BodyState(human, integrate(human.model, state.qpos, step))
    if not (np.linalg.norm(np.concatenate(error)) < 0.02 and 0.0 < width):
        raise ParameterError(f"the feet cannot stand level with the ankles {width:g} m apart")
    return np.array(state.qpos)


def on_ground(human: Human, ground: Ground, qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a configuration raised or lowered until the lowest contact sphere touches the ground.

    Raises:
        ParameterError: If the configuration does not fit this person.
    """
    if qpos.shape != (human.model.nq,) or not np.isfinite(qpos).all():
        raise ParameterError(f"a configuration of this person has {human.model.nq} finite numbers")
    data = _kinematics(human, qpos)
    sites = contact_sites(human)
    centre = np.array([data.geom(GEOM_PREFIX + s.name).xpos for s in sites])
    radius = np.array([[s.radius] for s in sites])
    normal = ground.normal_at(centre)
    sole = centre - radius * normal
    moved = qpos.copy()
    moved[2] -= ground.gap(sole).min() / ground.normal[2]
    return moved


def _leaning(
    human: Human, upright: Float[Array, " nq"], tilt: float, slope: float
) -> Float[Array, " nq"]:
    """Return standing tilted forward about the ankles, with the feet parallel to the ground."""
    qpos = upright.copy()
    qpos[3:7] = [np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0]
    for side in SIDES:
        qpos[7 + human.hinge(f"ankle_angle_{side}")] += tilt + slope
    return qpos


def _kinematics(human: Human, qpos: Float[Array, " nq"]) -> mujoco.MjData:
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(human.model, data)
    mujoco.mj_comPos(human.model, data)
    return data
