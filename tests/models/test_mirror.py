"""Mirror image of a person: sides are exchanged, lateral trunk rotations change sign."""

import numpy as np
import pytest

from plantigrade.models import JOINT_SETS, Human
from plantigrade.models.mirror import mirror_sign, mirrored_name


@pytest.mark.parametrize("joints", sorted(JOINT_SETS))
def test_forward_kinematics_commutes_with_mirroring(joints):
    """Forward kinematics of a mirrored posture is the mirror image of the posture's."""
    import mujoco

    human = Human.create(joints=joints)
    names = human.to_coordinates(human.standing()[None])[0]
    low, high = human.limits
    rng = np.random.default_rng(3)
    hinges = np.clip(0.3 * rng.normal(size=len(human.coordinates)), low, high)
    values = np.concatenate([[0.1, -0.2, 0.3, 0.5, 0.9, 0.2], hinges])
    column = dict(zip(names, values, strict=True))
    mirrored = np.array([mirror_sign(n) * column[mirrored_name(n)] for n in names])
    model, data = human.model, mujoco.MjData(human.model)
    place = []
    for each in (values, mirrored):
        data.qpos[:] = human.from_coordinates(names, each[None])[0]
        mujoco.mj_kinematics(model, data)
        place.append({name: data.xpos[human.body(name)].copy() for name in human.body_names})
    for name in human.body_names:
        expected = place[0][name] * [1.0, -1.0, 1.0]
        np.testing.assert_allclose(place[1][mirrored_name(name)], expected, atol=1e-9, err_msg=name)
