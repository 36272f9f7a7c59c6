"""A model that can be stepped at once: it stands, and its contacts are as stiff as asked for."""

import mujoco
import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.contact.simulation_model import simulation_xml
from plantigrade.errors import ParameterError
from plantigrade.models import Human


def stepped(human: Human, seconds: float = 1.0, **options):
    """Return model and data after some time from the key frame."""
    model = mujoco.MjModel.from_xml_string(simulation_xml(human, **options))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("standing").id)
    start = data.qpos[2]
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return model, data, start


@pytest.mark.parametrize(
    ("joints", "feet"), [("42", "two-segment"), ("58", "rigid"), ("66", "multi-segment")]
)
def test_servos_stand_and_sensors_weigh(joints, feet):
    human = Human.create(joints=joints, feet=feet)
    model, data, start = stepped(human, actuators="position", sensors=("feet",))
    assert [model.actuator(k).name for k in range(model.nu)] == list(human.coordinates)
    assert data.qpos[2] == pytest.approx(start, abs=0.01)
    forces = [data.sensor(f"ground_reaction_{side}").data for side in "rl"]
    assert sum(f[2] for f in forces) == pytest.approx(human.mass * GRAVITY, rel=0.03)
    assert forces[0][7] < 0 < forces[1][7]  # the right foot stands on the right


def test_motors_take_torques_within_the_strength():
    human = Human.create()
    model, data, start = stepped(human, 0.5, actuators="torque")
    assert data.qpos[2] < start - 0.05  # nothing holds the knees
    knee = model.actuator("knee_angle_r")
    assert knee.ctrlrange == pytest.approx(model.jnt_actfrcrange[model.joint("knee_angle_r").id])
    data.ctrl[knee.id] = 10.0
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[model.joint("knee_angle_r").dofadr[0]] == pytest.approx(10.0)


@pytest.mark.parametrize(
    "options", [{"foot_stiffness": 2e5}, {"foot_stiffness": 4e5, "ground_stiffness": 4e5}]
)
def test_contacts_have_the_requested_stiffness(options):
    """At rest a sphere is pressed in by its force over the stiffness; two springs are in series."""
    model, data, _ = stepped(Human.create(), actuators="position", **options)
    assert data.ncon >= 6
    found = []
    for k in range(data.ncon):
        force = np.zeros(6)
        mujoco.mj_contactForce(model, data, k, force)
        found.append(force[0] / -data.contact[k].dist)
    assert found == pytest.approx(np.full(data.ncon, 2e5), rel=0.15)


@pytest.mark.wrong_types
@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"actuators": "muscle"}, "must be one of torque, position"),
        ({"sensors": ("hands",)}, "'hands' are not known; there are feet"),
        ({"foot_stiffness": -1.0}, "stiffness of -1 N/m; allowed are 1000 to 1e"),
    ],
)
def test_a_value_that_is_not_allowed_is_refused(options, words):
    with pytest.raises(ParameterError, match=words):
        simulation_xml(Human.create(), **options)
