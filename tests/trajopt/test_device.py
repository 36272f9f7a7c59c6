"""Devices at joints: profiles over the stride, springs with a clutch, what they leave to people."""

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.trajopt import ContactBody, make_task
from plantigrade.trajopt.problem.dynamics import asked_by
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.terms.device import Device
from tests.models.presets import person

HUMAN = person("42", "two-segment")
WALK = make_task("walk", HUMAN, {"periodic": True})
ANKLE = "ankle_angle_r"


def worn(word: str):
    """Return the walk with a device in words."""
    return Impairments(device=(word,)).task(HUMAN, WALK)


def test_a_profile_rises_peaks_and_falls_over_the_stride_of_its_own_foot():
    task = worn("ankle=torque:-40@50,25,10")
    assert task.plan.mirrored and len(task.devices) == 2
    stride = 2 * task.plan.duration
    phase = np.array([0.2, 0.3, 0.5, 0.55, 0.61])
    right = next(d for d in task.devices if d.coordinate == ANKLE)
    found = right.values(phase * stride, task.plan)[:, 0]
    np.testing.assert_allclose(found[[0, 2, 3, 4]], [0.0, -40.0, -20.0, 0.0], atol=1e-9)
    assert -40.0 < found[1] < 0.0
    left = right.mirrored()
    half_later = left.values((phase + 0.5) * stride, task.plan)
    np.testing.assert_allclose(half_later[:, 0], found, atol=1e-9)


def test_a_spring_pulls_only_in_stance_and_beyond_its_angle():
    task = worn("ankle_r=spring:3@5")
    assert not task.plan.mirrored
    body = task.body_of(HUMAN)
    stride, i = task.plan.duration, HUMAN.hinge(ANKLE)
    times = np.array([0.3, 0.3, 0.8]) * stride
    q = np.zeros((3, len(HUMAN.coordinates)))
    q[:, i] = np.deg2rad([15.0, -15.0, 15.0])
    torque = body.external.torque_at(HUMAN.coordinates, times, q)
    np.testing.assert_allclose(torque[:, i], [-30.0, 0.0, 0.0], atol=0.1)
    assert not np.delete(torque, i, axis=1).any()


def test_the_person_gives_what_the_device_does_not():
    device = Device(ANKLE, torque=-30.0, stiffness=100.0, taut=-0.2)
    plan, feet = WALK.plan, foot_sites(HUMAN)
    bare, helped = (ContactBody(HUMAN, feet, plan=plan, devices=d) for d in ((), (device,)))
    rng, n = np.random.default_rng(2), bare.symbolic.nv
    q, v, a = (scale * rng.standard_normal((1, n)) for scale in (0.2, 1.0, 5.0))
    none, now = np.zeros((1, 3 * len(feet))), np.array([0.4 * 2 * plan.duration])
    (root, tau), (same, own) = asked_by(bare, q, v, a, none), asked_by(helped, q, v, a, none, now)
    np.testing.assert_allclose(same, root, atol=1e-12)
    added = helped.external.torque_at(HUMAN.coordinates, now, q[:, 6:])
    assert abs(added[0, HUMAN.hinge(ANKLE)]) > 1.0
    np.testing.assert_allclose(own + added, tau, atol=1e-9)


def test_bodies_share_functions_where_devices_differ_in_size_alone():
    one, two = worn("ankle=torque:-20"), worn("ankle=spring:2")
    body = one.body_of(HUMAN)
    other = body.wearing(two.devices)
    assert other.cache is body.cache and other.external.devices == two.devices
    assert body.external.devices == one.devices
    with pytest.raises(ParameterError, match="the body was made for"):
        body.wearing(worn("knee=torque:5").devices)


@pytest.mark.parametrize(
    ("word", "match"),
    [
        ("ankle", "write ankle=torque:-40"),
        ("ankle=motor:3", "write ankle=torque:NM"),
        ("ankle=torque:-40@50", "3 numbers"),
        ("ankle=spring:90", "must be 0–50 N m/deg"),
    ],
)
def test_words_that_say_nothing_are_refused(word, match):
    with pytest.raises(ParameterError, match=match):
        Impairments(device=(word,))


def test_a_device_needs_a_gait_and_a_joint_of_a_leg():
    squat = Impairments(device=("ankle=torque:-5",)).task(HUMAN, make_task("squat", HUMAN, {}))
    with pytest.raises(ParameterError, match="in a periodic walk or run"):
        squat.problem(squat.body_of(HUMAN))
    task = worn("ankle=torque:-5")
    with pytest.raises(ParameterError, match="task.body_of"):
        task.problem(ContactBody.for_plan(HUMAN, task.plan))


@pytest.mark.slow
def test_a_sweep_of_ankle_devices_starts_from_the_walk_without_and_says_what_they_save(tmp_path):
    """Torque is saved by motor and spring, work by a motor, and more by a strong one."""
    designs = [("ankle=torque:-20",), ("ankle=torque:-40",), ("ankle=spring:2",)]
    batch = pg.synthesize_many(
        "walk", vary={"device": designs}, periodic=True, speed=1.25, out=tmp_path / "sweep", jobs=1
    )
    weak, strong, spring = (pg.Run.load(item.folder) for item in batch)
    for run in (weak, strong, spring):
        assert run.status == "ok", run.status
        assert run.figures["iterations"] < (20 if run is spring else 10)  # a clutch is not smooth
        assert run.figures["device_own_torque_change_pct"] < -3.0
        device, own = run.record.device_torque, run.record.qfrc_actuator
        assert own is not None and np.abs(device).max() > 10.0
    changes = [run.figures["device_own_work_change_pct"] for run in (strong, weak)]
    assert changes[0] < changes[1] < -2.0
    assert strong.figures["device_ankle_angle_peak_n_m"] == pytest.approx(40.0, rel=0.01)
