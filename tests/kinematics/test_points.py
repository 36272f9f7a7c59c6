"""Points on bodies: positions against MuJoCo's, Jacobians against differences."""

import mujoco
import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound
from plantigrade.kinematics.points import Points
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from tests.models.presets import PRESETS, person, random_state


def landmark_points(human):
    places = attachments(human)
    names = list(places)
    return Points(
        human, [places[n].body for n in names], np.array([places[n].position for n in names])
    )


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_positions_and_jacobian(preset):
    human = person(*preset)
    points, rng, h = landmark_points(human), np.random.default_rng(0), 1e-6
    for _ in range(2):
        q, _ = random_state(human, rng)
        data = mujoco.MjData(human.model)
        data.qpos = q
        mujoco.mj_forward(human.model, data)
        x = points.at(q).copy()
        J = points.jacobian()
        for i, (body, local) in enumerate(zip(points.body, points.local, strict=True)):
            expected = data.xpos[body] + data.xmat[body].reshape(3, 3) @ local
            np.testing.assert_allclose(x[i], expected, atol=1e-13)
        numbers = np.empty_like(J)
        for k in range(human.model.nv):
            d = np.zeros(human.model.nv)
            d[k] = h
            ahead = points.at(points.integrate(q, d)).copy()
            behind = points.at(points.integrate(q, -d)).copy()
            numbers[:, :, k] = (ahead - behind) / (2 * h)
        np.testing.assert_allclose(J, numbers, atol=1e-8)


def test_the_jacobian_is_mujocos():
    human = person("66", "multi-segment")
    points = landmark_points(human)
    q, _ = random_state(human, np.random.default_rng(4))
    data = mujoco.MjData(human.model)
    data.qpos = q
    mujoco.mj_forward(human.model, data)
    x, J = points.at(q), points.jacobian()
    for i in range(0, len(x), 5):
        linear = np.zeros((3, human.model.nv))
        mujoco.mj_jac(human.model, data, linear, None, x[i], points.body[i])
        np.testing.assert_allclose(J[i], linear, atol=1e-12)


def test_rotations_are_those_of_the_last_configuration_and_a_copy():
    human = person("42", "rigid")
    points = Points(human, ["pelvis"], np.zeros((1, 3)))
    points.at(human.standing())
    before = points.rotations
    np.testing.assert_allclose(before[1], np.eye(3), atol=1e-15)
    turned = human.standing()
    turned[3:7] = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    points.at(turned)
    np.testing.assert_allclose(before[1], np.eye(3), atol=1e-15)
    np.testing.assert_allclose(points.rotations[1] @ [1, 0, 0], [0, 1, 0], atol=1e-12)


def test_other_lengths_move_the_points_and_leave_the_person_alone():
    human = person("42", "two-segment")
    longer = Human.create(1.74, 71.0, lengths={"thigh": 0.47, "upper_arm": 0.33})
    body, local = ["toes_r", "hand_l"], np.array([[0.02, 0.01, 0.0], [0.0, 0.02, -0.05]])
    points, direct = Points(human, body, local), Points(longer, body, local)
    kept = human.model.body_pos.copy()
    points.set_geometry(human.body_positions(longer.dimensions))
    q, _ = random_state(human, np.random.default_rng(2))
    np.testing.assert_allclose(points.at(q), direct.at(q), atol=1e-13)
    np.testing.assert_array_equal(human.model.body_pos, kept)


def test_an_unknown_body_is_refused():
    with pytest.raises(CoordinateNotFound, match="no body 'tail'"):
        Points(person("42", "rigid"), ["tail"], np.zeros((1, 3)))
