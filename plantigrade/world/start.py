"""How a person stands at the beginning: feet on the ground, weight over the feet."""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import GEOM, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human

PRESSURE = 0.45
"""Where people carry their weight in quiet standing, from the heel, of the length of the foot."""


def standing_on(human: Human, ground: Ground) -> Float[Array, " nq"]:
    """Return quiet standing: upright, soles along the ground, the centre of mass over the feet.

    The body leans about the ankles until its centre of mass is :data:`PRESSURE` of the length of
    the soles before the heels, some 5 cm before the ankles.
    """
    sites = contact_sites(human)
    lean = 0.0
    for _ in range(5):
        qpos = _leaning(human, lean, ground.slope)
        data = _placed(human, qpos)
        x = np.array([data.geom(GEOM + s.name).xpos[0] for s in sites])
        wanted = x.min() + PRESSURE * np.ptp(x)
        ankle = float(np.mean([data.body(f"foot_{s}").xpos[2] for s in ("r", "l")]))
        lean += float(wanted - data.subtree_com[1, 0]) / float(data.subtree_com[1, 2] - ankle)
    return on_ground(human, ground, _leaning(human, lean, ground.slope))


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


def _leaning(human: Human, lean: float, slope: float) -> Float[Array, " nq"]:
    """Return the standing person turned forward about the ankles, feet turned with the ground."""
    qpos = human.standing()
    qpos[3:7] = [np.cos(lean / 2), 0.0, np.sin(lean / 2), 0.0]
    for side in ("r", "l"):
        qpos[7 + human.hinge(f"ankle_angle_{side}")] += lean + slope
    return qpos


def _placed(human: Human, qpos: Float[Array, " nq"]) -> mujoco.MjData:
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(human.model, data)
    mujoco.mj_comPos(human.model, data)
    return data
