"""The judge of motions: what is physical passes, every single fault is found and named."""

import mujoco
import numpy as np
import pytest

from plantigrade import Ground
from plantigrade import check as examine
from plantigrade.analyze import Tolerances
from plantigrade.analyze.pressure import distance_outside_hull
from plantigrade.analyze.quantities import QUANTITIES
from plantigrade.constants import GRAVITY as G
from plantigrade.contact.ground import Seat
from plantigrade.contact.relief import HeightField
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.record import Limits, Record, Run
from tests.analyze.bodies import MOTION, having, person, record_of, sites_of, still
from tests.analyze.standing import balancing_forces, free_of_limits, standing_record

BALL = """
<mujoco><worldbody><body name="ball_r" pos="0 0 0.1"><freejoint/>
<inertial pos="0 0 0" mass="2" diaginertia="0.008 0.008 0.008"/>
<geom name="contact_box_a_r" type="sphere" size="0.1"/></body></worldbody></mujoco>
"""
BOX = """
<mujoco><worldbody><body name="box_r"><freejoint/>
<inertial pos="0 0 0.2" mass="5" diaginertia="0.1 0.1 0.1"/>
<geom name="contact_box_a_r" type="sphere" size="0.02" pos="0.1 0.1 0"/>
<geom name="contact_box_b_r" type="sphere" size="0.02" pos="0.1 -0.1 0"/>
<geom name="contact_box_c_r" type="sphere" size="0.02" pos="-0.1 0.1 0"/>
<geom name="contact_box_d_r" type="sphere" size="0.02" pos="-0.1 -0.1 0"/>
</body></worldbody></mujoco>
"""


def plateau(corner, height) -> HeightField:
    """A rectangle of 4 m each way that is higher than the ground around it."""
    return HeightField(corner, (4.0, 4.0), ((height, height), (height, height)))


@pytest.fixture(scope="module")
def human() -> Human:
    return standing_record().human


@pytest.fixture(scope="module")
def standing() -> Record:
    """A person who stands still on both feet, weight shared, and swings the arms a little."""
    return having(standing_record(), qfrc_actuator=None, contact_point=None)


def test_standing_with_the_weight_shared_is_fine(standing):
    check = examine(standing)
    assert check.ok, check.sentences()
    assert len(check.sentences()) == 1
    total = standing.contact_force.sum(axis=1)[:, 2]
    assert abs(total - 70.0 * G).max() < 0.1 * 70.0 * G  # it is indeed a body that stands


def test_the_torque_of_the_ankle_balances_what_presses_on_the_foot(human, standing):
    check = examine(standing)
    model, data = human.model, mujoco.MjData(human.model)
    data.qpos[:] = standing.motion.qpos[0]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    for side in ("r", "l"):
        joint = model.joint(f"ankle_angle_{side}").id
        anchor, axis = data.xanchor[joint], data.xaxis[joint]
        foot = model.joint(joint).bodyid[0]
        weight = model.body_subtreemass[foot] * np.array([0.0, 0.0, -G])
        moment = np.cross(data.subtree_com[foot] - anchor, weight)
        for i, site in enumerate(standing.sites):
            if site.side == side:
                arm = check.contact_point[0, i] - anchor
                moment += np.cross(arm, standing.contact_force[0, i])
        torque = check.tau[0, 6 + human.hinge(f"ankle_angle_{side}")]
        assert torque == pytest.approx(-axis @ moment, abs=1e-9)
        assert abs(torque) > 3.0  # [N m] the weight is before the ankles


def quantities(check) -> set[str]:
    return {finding.quantity for finding in check.findings}


@pytest.fixture
def box() -> Record:
    """A box that stands on its four spheres."""
    box = person(BOX)
    t, qpos, qvel, qacc, sites = still(box, [0, 0, 0.02, 1, 0, 0, 0])
    force = np.zeros((len(t), 4, 3))
    force[..., 2] = 5.0 * G / 4.0
    return record_of(box, t, qpos, qvel, qacc, sites, force, np.ones((len(t), 4), bool))


def ballistic(model, qpos, qvel, torque, duration=0.4, step=1e-3):
    """A flight under the torques of the joints, by MuJoCo's forward dynamics and RK4."""
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = step
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    states = []
    for i in range(int(duration / step) + 1):
        data.qfrc_applied[6:] = torque
        mujoco.mj_forward(model, data)
        states.append((i * step, data.qpos.copy(), data.qvel.copy(), data.qacc.copy()))
        mujoco.mj_step(model, data)
    return tuple(np.array(each) for each in zip(*states, strict=True))


# What is physical passes --------------------------------------------------------------------------


def test_flight_needs_no_force(human):
    rng = np.random.default_rng(3)
    model = free_of_limits(human)
    qpos = human.standing()
    qpos[2] += 0.4
    qvel = 0.3 * rng.normal(size=model.nv)
    qvel[2] = 2.0
    torque = np.zeros(model.nv - 6)
    for name, value in (("hip_flexion_r", 3.0), ("lumbar_bending", -2.0), ("arm_flex_l", 1.0)):
        torque[human.hinge(name)] = value
    t, q, v, a = ballistic(model, qpos, qvel, torque)
    sites = sites_of(human)
    none = np.zeros((len(t), len(sites), 3))
    flight = record_of(human, t, q, v, a, sites, none, np.zeros((len(t), len(sites)), bool))
    limits = Limits(coordinate=np.array([[-9.0], [9.0]]) * np.ones((2, model.nv - 6)))
    check = examine(having(flight, limits=limits))
    assert check.ok, check.sentences()
    np.testing.assert_allclose(check.tau[:, 6:], np.tile(torque, (len(t), 1)), atol=1e-6)
    assert np.isnan(check.centre_of_pressure).all()
    assert np.isnan(check.measures["slip"].value)
    # The judge counts twice, once with accelerations, once with momentum and energy.
    assert check.measures["momentum"].value < 0.01
    assert check.measures["energy"].value < 0.01

    hanging = examine(having(flight, qacc=0 * flight.motion.qacc, limits=limits))
    worst = hanging.findings[0]  # a body that does not fall is carried by something
    assert not hanging.ok and "root_force" in quantities(hanging)
    assert hanging.measures["root_force"].value == pytest.approx(100.0, abs=8.0)
    assert worst.sentence()


@pytest.mark.parametrize("spin", [1.0, 0.9, 0.0])
def test_a_ball_may_roll_but_not_slip(spin):
    ball = person(BALL)
    speed, radius, n = 0.5, 0.1, 101
    t = np.linspace(0.0, 0.5, n)
    turn = spin * speed / radius
    qpos = np.zeros((n, 7))
    qpos[:, 0], qpos[:, 2] = speed * t, radius
    qpos[:, 3], qpos[:, 5] = np.cos(0.5 * turn * t), np.sin(0.5 * turn * t)
    qvel, qacc = np.zeros((n, 6)), np.zeros((n, 6))
    qvel[:, 0], qvel[:, 4] = speed, turn
    force = np.zeros((n, 1, 3))
    force[..., 2] = 2.0 * G
    stands = np.ones((n, 1), bool)
    stands[:20] = False
    force[:20] = 0.0
    motion = record_of(ball, t, qpos, qvel, qacc, sites_of(ball), force, stands)
    # In the first tenth of a second nothing carries the ball, and that is found, too.
    check = examine(motion)
    slid = 1000.0 * (1.0 - spin) * speed * (t[-1] - t[20])
    assert check.measures["slip"].value == pytest.approx(slid, abs=1e-9)
    assert check.measures["slip_speed"].value == pytest.approx((1.0 - spin) * speed, abs=1e-12)
    assert quantities(check) == {"root_force"} | ({"slip"} if spin < 1 else set())
    force[:20, :, 2], stands[:20] = 2.0 * G, True
    assert quantities(examine(motion)) == ({"slip"} if spin < 1 else set())


def test_a_box_rests_on_a_slope_as_steep_as_friction_allows(box):
    steep = np.deg2rad(20.0)
    n = len(box.motion.time)
    slope_down = Ground(slope=-steep, friction=0.37)  # downhill is +x
    normal = slope_down.normal
    qpos = np.zeros((n, 7))
    qpos[:, :3] = 0.02 * normal
    qpos[:, 3], qpos[:, 5] = np.cos(0.5 * steep), np.sin(0.5 * steep)
    # All forces point up; their centre is on the vertical through the centre of mass.
    down = 0.22 * np.tan(steep) / 0.1
    share = np.array([1 + down, 1 + down, 1 - down, 1 - down]) / 4.0
    force = np.zeros((n, 4, 3))
    force[..., 2] = 5.0 * G * share
    slope = having(box, qpos=qpos, contact_force=force, ground=slope_down)
    check = examine(slope)
    assert check.ok, check.sentences()
    assert check.measures["friction"].value == pytest.approx(np.tan(steep))
    assert check.measures["penetration"].value == pytest.approx(0.0, abs=1e-9)
    margin = 1000.0 * (0.1 - 0.1 * down) * np.cos(steep)  # counts in proportion to the load
    assert check.measures["pressure"].value == pytest.approx(-margin)

    check = examine(having(slope, ground=Ground(slope=-steep, friction=0.3)))
    (finding,) = check.findings
    assert finding.quantity == "friction" and finding.side == "r"
    assert finding.value == pytest.approx(np.tan(steep)) and finding.limit == 0.3
    assert "friction of 0.364" in finding.sentence()


def test_feet_on_two_levels_that_push_against_each_other(box):
    """The pressure under feet on a step is their mean, however they lean on each other."""
    uneven = person(BOX.replace('pos="0.1 0.1 0"', 'pos="0.1 0.1 0.15"'))
    sites = sites_of(uneven)
    force = box.contact_force.copy()
    force[:, 0, 0], force[:, 2, 0] = -2.0, 2.0  # site a is 0.15 higher: a couple of 0.3 N m
    force[:, (0, 1), 2] -= 0.3 / 0.4
    force[:, (2, 3), 2] += 0.3 / 0.4
    ground = Ground(field=plateau((0.05, 0.05), 0.15), friction=0.5)
    check = examine(having(box, human=uneven, sites=sites, contact_force=force, ground=ground))
    assert check.ok, check.sentences()
    load = force[0, :, 2]
    expected = load @ check.contact_point[0, :, :2] / load.sum()
    np.testing.assert_allclose(
        check.centre_of_pressure[:, :2], np.tile(expected, (61, 1)), atol=1e-9
    )


def test_a_seat_carries_but_is_no_foot(box):
    seat = ContactSite(body="box_r", position=(-0.15, 0.0, 0.3), name="seat", part="chair")
    ground = Ground(seats=(Seat("seat", (-0.15, 0.0, 0.32)),))
    sites = (*box.sites, seat)
    n = len(box.motion.time)
    force = np.zeros((n, 5, 3))
    load = 0.5 * 5.0 * G
    force[:, 4, 2] = load
    # Without the seat's half the feet must push at x = 0.15, outside of them: they cannot.
    force[:, :2, 2] = 0.25 * load
    force[:, 2:4, 2] = 0.25 * load
    planned = np.ones((n, 5), bool)
    sits = having(box, sites=sites, contact_force=force, contact_planned=planned, ground=ground)
    check = examine(sits)
    assert quantities(check) == {"root_moment", "pressure"}
    assert check.measures["pressure"].value == pytest.approx(0.5 * 50.0)  # half of the weight
    force[:, 4, 2], force[:, :2, 2], force[:, 2:4, 2] = 0.4 * 5 * G, 0.6 * 5 * G / 2, 0.0
    check = examine(sits)
    assert check.ok, check.sentences()
    np.testing.assert_allclose(check.centre_of_pressure[0, :2], [0.1, 0.0], atol=1e-9)

    rises = np.ones((n, 5), bool)
    rises[:, 4] = False
    check = examine(having(sits, contact_planned=rises))
    (finding,) = check.findings
    assert (finding.quantity, finding.name) == ("unsupported", "seat")
    assert finding.value == pytest.approx(40.0)


# Every fault is found, and nothing else -----------------------------------------------------------


def test_a_foot_that_slides_is_found_where_and_when_it_slides(human, standing):
    t = standing.motion.time
    s = np.clip((t - 0.3) / 0.6, 0.0, 1.0)
    way = 0.005 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    rate = 0.005 / 0.6 * (30 * s**2 - 60 * s**3 + 30 * s**4)
    second = 0.005 / 0.6**2 * (60 * s - 180 * s**2 + 120 * s**3)
    qpos, qvel, qacc = (
        standing.motion.qpos.copy(),
        standing.motion.qvel.copy(),
        standing.motion.qacc.copy(),
    )
    qpos[:, 1] += way
    qvel[:, 1] += rate
    qacc[:, 1] += second
    force = balancing_forces(free_of_limits(human), standing.sites, qpos, qvel, qacc)
    moved = having(standing, qpos=qpos, qvel=qvel, qacc=qacc, contact_force=force)
    check = examine(moved)
    assert quantities(check) == {"slip"}
    assert {finding.side for finding in check.findings} == {"l", "r"}
    for finding in check.findings:
        assert finding.value == pytest.approx(5.0, rel=1e-4)
        assert 0.35 < finding.start < 0.45 and 0.75 < finding.end < 0.85
        assert len(finding.others) == 6
        assert "6 more places of that foot" in finding.sentence()
        assert "slips 5 mm" in finding.sentence() and "at most 3 mm" in finding.sentence()
    assert all(s.start == t[0] and s.end == t[-1] for s in check.slips)
    assert examine(moved, Tolerances(slip=6.0)).ok


def test_a_foot_that_pivots_slips_everywhere_but_at_the_pivot(box):
    n, turn = len(box.motion.time), 0.05  # [rad/s]
    angle = turn * box.motion.time
    corner = np.array([0.1, 0.1])
    arm = -corner  # from the pivot to the middle
    c, s = np.cos(angle), np.sin(angle)
    qpos, qvel, qacc = box.motion.qpos.copy(), np.zeros((n, 6)), np.zeros((n, 6))
    around = np.stack([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]], axis=1)
    qpos[:, :2] = corner + around
    qpos[:, 3], qpos[:, 6] = np.cos(0.5 * angle), np.sin(0.5 * angle)
    qvel[:, :2] = turn * np.stack([-around[:, 1], around[:, 0]], axis=1)
    qvel[:, 5] = turn
    qacc[:, :2] = -(turn**2) * around
    force = balancing_forces(box.human.model, box.sites, qpos, qvel, qacc)
    check = examine(having(box, qpos=qpos, qvel=qvel, qacc=qacc, contact_force=force))
    (finding,) = check.findings
    assert (finding.quantity, finding.name, finding.side) == ("slip", "d_r", "r")
    assert finding.others == ("b_r", "c_r")
    chord = 2.0 * np.hypot(0.2, 0.2) * np.sin(0.5 * angle[-1])
    assert finding.value == pytest.approx(1000.0 * chord, rel=1e-4)
    assert finding.where == "right d"


def test_a_foot_in_the_ground_and_one_above_it(standing):
    left_higher = Ground(field=plateau((-2.0, 0.0), 0.004))
    check = examine(having(standing, ground=left_higher))
    (finding,) = check.findings
    assert (finding.quantity, finding.side, len(finding.others)) == ("penetration", "l", 6)
    assert finding.value == pytest.approx(4.0, abs=0.1) and finding.limit == 2.0
    assert (finding.start, finding.end) == (standing.motion.time[0], standing.motion.time[-1])
    left_lower = Ground(height=-0.004, field=plateau((-2.0, -4.0), 0.004))
    check = examine(having(standing, ground=left_lower))
    (finding,) = check.findings
    assert (finding.quantity, finding.side) == ("hover", "l")
    assert finding.value == pytest.approx(4.0, abs=0.6)  # the ankle axis tilts the foot a little


def test_a_sphere_that_is_no_site_must_not_sink_either(box):
    extra = '<geom name="contact_box_e_r" type="sphere" size="0.02" pos="0 0 -0.005"/></body>'
    other = person(BOX.replace("</body>", extra, 1))
    (finding,) = examine(having(box, human=other)).findings
    assert (finding.quantity, finding.name) == ("penetration", "box_e_r")
    assert finding.value == pytest.approx(5.0)


def test_forces_that_do_not_carry_the_body(standing):
    check = examine(having(standing, contact_force=1.05 * standing.contact_force))
    (finding,) = check.findings
    assert finding.quantity == "root_force" and finding.name == finding.side == ""
    assert finding.value == pytest.approx(5.0, abs=0.1)
    # Always a little is worse than once in a while as much: both bounds are there.
    check = examine(having(standing, contact_force=1.007 * standing.contact_force))
    (finding,) = check.findings
    assert finding.quantity == "root_force_rms" and "over the whole motion" in finding.sentence()
    once = standing.contact_force.copy()
    once[100:120] *= 1.007
    assert examine(having(standing, contact_force=once)).ok
    once[100:120] *= 1.007
    (finding,) = examine(having(standing, contact_force=once)).findings
    assert finding.quantity == "root_force"
    assert finding.start == standing.motion.time[100] and finding.end == standing.motion.time[119]


def test_ground_that_pulls(box):
    force = box.contact_force.copy()
    crossed = np.array([-1.0, 1.0, 1.0, -1.0])  # neither force nor moment in sum
    force[20:31, :, 2] += 1.1 * 5.0 * G / 4.0 * crossed
    (finding,) = examine(having(box, contact_force=force)).findings
    assert finding.quantity == "adhesion" and {finding.name, *finding.others} == {"a_r", "d_r"}
    assert finding.value == pytest.approx(2.5)
    assert (finding.start, finding.end) == (box.motion.time[20], box.motion.time[30])


def test_force_of_a_site_that_does_not_stand(standing):
    toe = next(i for i, s in enumerate(standing.sites) if s.name == "toe_3_r")
    stands = standing.contact_planned.copy()
    stands[80:121, toe] = False
    (finding,) = examine(having(standing, contact_planned=stands)).findings
    assert (finding.quantity, finding.name) == ("unsupported", "toe_3_r")
    assert (finding.start, finding.end) == (standing.motion.time[80], standing.motion.time[120])


def test_a_site_that_carries_too_much(box):
    most = 5.0 * G / 4.0
    assert examine(having(box, limits=Limits(force=most))).ok
    (finding,) = examine(having(box, limits=Limits(force=0.9 * most))).findings
    assert finding.quantity == "force" and finding.unit == "N"
    assert finding.value == pytest.approx(most) and finding.limit == pytest.approx(0.9 * most)


def test_weight_outside_the_base_of_support(box):
    stands = box.contact_planned.copy()
    stands[:, :2] = False
    force = box.contact_force.copy()
    force[:, :2], force[:, 2:] = 0.0, 2.0 * force[:, 2:]
    check = examine(having(box, contact_force=force, contact_planned=stands))
    assert quantities(check) == {"root_moment", "pressure"}
    (finding,) = (f for f in check.findings if f.quantity == "pressure")
    assert finding.name == "the feet" and finding.value == pytest.approx(100.0)
    assert check.measures["root_moment"].value == pytest.approx(10.0)  # 0.1 m beside it


ARM = """
<mujoco><worldbody><body name="box_r"><freejoint/>
<inertial pos="0 0 0.2" mass="50" diaginertia="1 1 1"/>
<geom name="contact_box_a_r" type="sphere" size="0.02" pos="0.5 0.5 0"/>
<geom name="contact_box_b_r" type="sphere" size="0.02" pos="0.5 -0.5 0"/>
<geom name="contact_box_c_r" type="sphere" size="0.02" pos="-0.5 0 0"/>
<body name="arm" pos="0 0 0.5">
<joint name="shoulder_l" type="hinge" axis="0 -1 0" range="-10 10" limited="true"
 actuatorfrcrange="-2 2.5"/>
<inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></body></worldbody></mujoco>
"""


def test_a_joint_that_is_too_weak_for_its_arm():
    arm = person(ARM)
    t, qpos, qvel, qacc, sites = still(arm, [0, 0, 0.02, 1, 0, 0, 0, 0])
    force = balancing_forces(arm.model, sites, qpos, qvel, qacc)
    motion = record_of(arm, t, qpos, qvel, qacc, sites, force, np.ones((len(t), 3), bool))
    (finding,) = examine(motion).findings
    assert (finding.quantity, finding.name, finding.side) == ("torque", "shoulder_l", "l")
    assert finding.value == pytest.approx(0.3 * G)  # held level, one kilogram at 0.3 m
    assert (finding.limit, finding.unit) == (2.5, "N m")
    assert "shoulder_l needs 2.94 N m between 0.00 and 0.60 s" in finding.sentence()
    assert examine(having(motion, limits=Limits(torque=np.array([[0.0], [3.0]])))).ok
    other = Limits(torque=np.array([[-3.0], [0.0]]))  # strong, but the other way
    assert quantities(examine(having(motion, limits=other))) == {"torque"}


def test_limits_of_joints_and_of_their_speed(human, standing):
    n = human.model.nv - 6
    assert examine(having(standing, limits=Limits(velocity=1.81))).ok
    (finding,) = (
        f for f in examine(having(standing, limits=Limits(velocity=1.5))).findings if f.time == 0.0
    )
    assert (finding.quantity, finding.name, finding.side) == ("velocity", "arm_flex_r", "r")
    assert finding.value == pytest.approx(1.8) and finding.limit == 1.5
    assert finding.end < np.arccos(1.5 / 1.8) / 6.0 + 0.01
    each = np.full(n, 1.5)
    each[human.hinge("arm_flex_r")] = 2.0
    assert examine(having(standing, limits=Limits(velocity=each))).ok
    check = examine(having(standing, limits=Limits(velocity=1.5)))
    assert len(check.findings) == 3 and {f.name for f in check.findings} == {"arm_flex_r"}
    (sentence,) = check.sentences()
    assert "1.8 rad/s" in sentence and "and 2 more times; at most 1.5 rad/s" in sentence
    narrow = human.limits.copy()
    k = human.hinge("arm_flex_l")
    narrow[0, k] = human.standing()[7 + k] - 0.1
    check = examine(having(standing, limits=Limits(coordinate=narrow)))
    assert quantities(check) == {"coordinate"}
    assert {f.name for f in check.findings} == {"arm_flex_l"}
    assert check.measures["coordinate"].value == pytest.approx(np.rad2deg(0.1), rel=1e-3)
    assert check.measures["coordinate"].time == pytest.approx(0.5 * np.pi / 5.0, abs=0.005)


def test_velocities_and_accelerations_of_another_motion(human, standing):
    k = human.hinge("elbow_flex_r")
    qvel = standing.motion.qvel.copy()
    qvel[100:141, 6 + k] += 0.1
    (finding,) = examine(having(standing, qvel=qvel)).findings
    assert (finding.quantity, finding.name) == ("velocity_mismatch", "elbow_flex_r")
    assert finding.start == pytest.approx(0.5, abs=0.01)
    assert finding.end == pytest.approx(0.7, abs=0.01)
    qacc = standing.motion.qacc.copy()
    qacc[100:141, 6 + k] += 2.0
    (finding,) = examine(having(standing, qacc=qacc)).findings
    assert (finding.quantity, finding.name) == ("acceleration_mismatch", "elbow_flex_r")
    assert finding.start == pytest.approx(0.5, abs=0.01)
    slower = having(standing, time=1.1 * standing.motion.time)
    assert quantities(examine(slower)) == {"velocity_mismatch", "acceleration_mismatch"}


# Figures, words, input ----------------------------------------------------------------------------


def test_figures_are_flat_and_words_are_sentences(standing):
    import json

    check = examine(standing)
    metrics = check.figures()
    assert set(check.measures) == set(QUANTITIES)
    assert metrics["check_ok"] is True and metrics["check_findings"] == 0
    assert metrics["check_root_force_rms_bw_percent"] < 1e-6
    json.dumps({k: None if v != v else v for k, v in metrics.items()}, allow_nan=False)
    broken = having(standing, contact_force=0.5 * standing.contact_force)
    for sentence in examine(broken).sentences():
        assert "at most" in sentence and " s; " in sentence


def test_distance_from_a_hull_is_that_of_a_fine_drawing_of_it():
    rng = np.random.default_rng(0)
    n, k = 40, 6
    corners, point = rng.normal(size=(n, k, 2)), 2.0 * rng.normal(size=(n, 2))
    there = rng.random((n, k)) < 0.6
    found = distance_outside_hull(point, corners, there)
    line = np.linspace(0.0, 1.0, 201)[:, None]
    for f in range(n):
        x = corners[f, there[f]]
        if not len(x):
            assert np.isnan(found[f])
            continue
        edges = np.concatenate([a + line * (b - a) for a in x for b in x])
        inner = np.concatenate(
            [edges[::7] + s * (x[0] - edges[::7]) for s in np.linspace(0, 1, 21)]
        )
        near = np.linalg.norm(np.concatenate([edges, inner]) - point[f], axis=1).min()
        assert found[f] <= near + 1e-9
        if found[f] > 0:
            assert found[f] == pytest.approx(near, abs=0.02)
        else:
            assert near < 0.4


def test_a_run_folder_can_be_checked_again(tmp_path, standing):
    first = examine(standing)
    record = having(
        standing,
        qfrc_actuator=first.tau,
        contact_point=first.contact_point,
        ground=Ground(friction=0.7),
        signals=first.signals(),
    )
    Run(record, "synthesize", figures=first.figures()).save(tmp_path / "run")
    again = Run.load(tmp_path / "run").record
    assert again.ground.friction == 0.7
    check = examine(again)
    assert check.ok and check.status == "ok", check.sentences()
    np.testing.assert_allclose(check.tau, first.tau, atol=1e-9)
    assert list(again.signals["check.quantity"]) == list(QUANTITIES)

    unplanned = having(again, contact_planned=None)  # then a site stands where it carries
    pushed = having(unplanned, contact_force=1.05 * standing.contact_force)
    assert quantities(examine(pushed)) == {"root_force"}


def test_measured_forces_act_where_the_plates_say():
    """A walk over plates: no plan, no spheres, but the same laws."""
    from tests.analyze.plated_walk import analyse, plated_walk

    record = analyse(plated_walk().fit(), cutoff=None).record()
    record = having(
        record,
        **{k: getattr(record.motion, k)[10:-10] for k in MOTION},
        **{
            k: getattr(record, k)[10:-10]
            for k in (
                "qfrc_actuator",
                "contact_force",
                "contact_point",
                "contact_torque",
                "contact_known",
            )
        },
    )
    check = examine(record)
    assert check.measures["root_force"].value < 1.0  # [% of body weight]
    np.testing.assert_allclose(check.tau, record.qfrc_actuator, atol=1e-6)
    assert np.isnan(check.measures["hover"].value)
    hidden = record.contact_known.copy()
    hidden[: len(hidden) // 2] = False
    lost = having(
        record, contact_known=hidden, contact_force=record.contact_force * hidden[..., None]
    )
    assert examine(lost).measures["root_force"].value < 1.0
    unknown = examine(having(record, contact_force=None, contact_known=None))
    assert np.isnan(unknown.measures["root_force"].value)


def test_what_does_not_belong_together_is_refused(box):
    with pytest.raises(ParameterError, match="increasing"):
        examine(having(box, time=box.motion.time[::-1].copy()))
    bad = box.motion.qvel.copy()
    bad[7] = np.nan
    with pytest.raises(ParameterError, match="qvel has missing values .*frame 7"):
        examine(having(box, qvel=bad))
    elsewhere = ContactSite(body="hand", name="x", side="r")
    with pytest.raises(ParameterError, match="no body 'hand'; there are box_r"):
        examine(having(box, sites=(elsewhere, *box.sites[1:])))
    with pytest.raises(ParameterError, match="length one"):
        examine(having(box, qpos=2.0 * box.motion.qpos))
    with pytest.raises(ParameterError, match="without accelerations"):
        examine(having(box, qacc=None))
