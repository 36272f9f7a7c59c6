"""Walking by an inverted pendulum: the whole, and the parts that need a body."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.disturbance import DisturbanceEstimator, DisturbanceSettings
from plantigrade.control.gait.loads import transferred
from plantigrade.control.gait.person import SoleShape
from plantigrade.control.gait.phase import Foot
from plantigrade.control.gait.reference import STEP, ReferenceSettings, reference_of
from plantigrade.control.gait.swing import SwingOffset
from plantigrade.control.pendulum import Pendulum, PendulumSettings, walk_of
from plantigrade.control.pendulum.hold import CommandHold
from plantigrade.control.pendulum.reference import with_feasible_com
from plantigrade.control.pendulum.summary import Footfall, walk_summary
from plantigrade.control.pendulum.swing import SwingPath, bent_way, detours, limit_to_reach
from plantigrade.control.pendulum.swing_clearance import with_clearance
from plantigrade.control.pendulum.tasks import WalkingTasks
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record, Run
from plantigrade.spatial.conventions import about_vertical, turned
from plantigrade.workflows.simulate import simulate
from plantigrade.world import Push, StablePD, World

SETTINGS = PendulumSettings()


def test_a_summary_counts_footsteps_with_and_without_a_plan():
    footfalls = [Footfall(0.5, "r", 0.01, 0.0), Footfall(1.0, "l", 0.03, 0.2)]
    found = walk_summary(footfalls, 1.2, 1.3, -0.15)
    assert len(found.sentences) == 2
    assert found.figures["landings"] == 2 and found.figures["landings_shortened"] == 1
    assert found.figures["landing_error_median_m"] == pytest.approx(0.02)
    assert walk_summary([], 0.0, 0.0, 0.0).sentences == ()
    fell = walk_summary([Footfall(0.3, "l", None, 0.0)], 0.1, 1.2, 0.0)
    assert len(fell.sentences) == 1 and "landing_error_median_m" not in fell.figures


@pytest.fixture(scope="module")
def begun(walk, world_of):
    """The controller, the world and the state after the first step."""
    controller = Pendulum(walk)
    world = world_of(controller)
    state = world.reset()
    while world.time < 0.6:
        command = controller(state)
        assert command.signals["solved"] == 1.0
        state = world.step(command)
    return controller, world, state


@pytest.mark.parametrize("heading", [90.0, 180.0, -60.0])
def test_a_walk_that_repeats_itself_is_turned_to_lead_along_x(walk, heading):
    motion, angle = walk.motion, np.deg2rad(heading)
    qpos, qvel, turn = motion.qpos.copy(), motion.qvel.copy(), about_vertical(angle)
    qpos[:, :3], qpos[:, 3:7] = qpos[:, :3] @ turn.T, turned(qpos[:, 3:7], angle)
    qvel[:, :3] = qvel[:, :3] @ turn.T
    led = walk_of(replace(walk, motion=replace(motion, qpos=qpos, qvel=qvel))).motion
    np.testing.assert_allclose(led.qpos[:, :3], motion.qpos[:, :3], atol=1e-9)
    np.testing.assert_allclose(led.qvel, motion.qvel, atol=1e-9)
    same = np.abs((led.qpos[:, 3:7] * motion.qpos[:, 3:7]).sum(axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-9)


def test_a_stride_is_closed_and_a_walk_without_one_is_walked_once(walk):
    motion = walk.motion
    np.testing.assert_allclose(motion.qpos[-1, 3:], motion.qpos[0, 3:], atol=1e-9)
    assert motion.qpos[-1, 0] - motion.qpos[0, 0] == pytest.approx(1.2 * motion.duration, rel=0.1)
    assert walk_of(walk) is walk
    part = motion.frames(np.arange(motion.n_frames // 3))
    once = walk_of(replace(walk, motion=part))
    assert len(once.notes) == len(walk.notes) + 1
    assert Pendulum(once).duration == part.duration
    assert Pendulum(walk).duration == 10.0
    before = Run(replace(once, notes=("Of before.",)), "fit")
    notes = simulate(before, controller="pendulum", duration=0.01).record.notes
    assert once.notes[-1] in notes and "Of before." not in notes


def test_the_load_goes_evenly_from_foot_to_foot_in_a_double_support():
    right, left, both = [True, False], [False, True], [True, True]
    share = transferred(np.array([both, right, both, both, left, both, left, [False, False]]))
    expected = [[0.5, 0.5], [1, 0], [0.75, 0.25], [0.25, 0.75], [0, 1], [0.5, 0.5], [0, 1], [0, 0]]
    np.testing.assert_allclose(share, expected)


def over_ground(reference):
    """Return centre of mass, its velocity and acceleration, and centre of pressure [m]."""
    rows = reference.rows
    fields = rows.com, rows.com_velocity, rows.com_acceleration, rows.cop
    return (each[:, :2] for each in fields)


def test_the_mass_of_a_periodic_walk_moves_as_its_feet_can_bear_it(walk):
    recorded = reference_of(walk_of(walk))
    found = with_feasible_com(recorded, cop_smoothing=0.03)
    com, velocity, acceleration, cop = over_ground(found)
    n = len(com) - 1
    roughness = [np.abs(np.diff(each.rows.cop[:, 0], 2)).max() for each in (found, recorded)]
    assert roughness[0] < 0.2 * roughness[1]
    np.testing.assert_allclose(acceleration[:n], found.omega**2 * (com - cop)[:n], atol=1e-9)
    for value, rate in ((com, velocity), (velocity, acceleration)):  # one motion, and it closes
        gone = STEP * np.cumsum(0.5 * (rate[1:n] + rate[: n - 1]), axis=0)
        np.testing.assert_allclose(value[1:n] - value[0], gone, atol=2e-3)
    np.testing.assert_allclose(com[-1] - com[0], found.advance[:2], atol=1e-9)
    assert np.abs(found.rows.com - recorded.rows.com).max(axis=0) == pytest.approx(0.0, abs=0.04)
    np.testing.assert_array_equal(found.rows.com[:, 2], recorded.rows.com[:, 2])


def test_a_walk_whose_stance_feet_slide_stands_on_the_slower_one(walk):
    motion = walk.motion
    qpos, qvel = motion.qpos.copy(), motion.qvel.copy()
    qpos[:, 1] += 0.6 * (motion.time - motion.time[0])  # as where a stride of a turn was closed
    qvel[:, 1] += 0.6
    slides = replace(walk, motion=replace(motion, qpos=qpos, qvel=qvel, qacc=None, events=()))
    flies, walks = (
        1.0 - reference_of(slides, settings=settings).rows.contact.any(axis=1).mean()
        for settings in (ReferenceSettings(), PendulumSettings().reference)
    )
    assert flies > 0.5 and walks < 0.05


def test_the_mass_of_a_walk_that_ends_does_so_between_its_ends(walk):
    motion = walk_of(walk).motion
    part = replace(walk, motion=motion.frames(np.arange(9 * motion.n_frames // 10)))
    recorded = reference_of(part)
    found = with_feasible_com(recorded)
    assert recorded.period is None and not recorded.ends
    (was, *_), (com, velocity, acceleration, cop) = map(over_ground, (recorded, found))
    np.testing.assert_array_equal(com[[0, -1]], was[[0, -1]])
    assert np.abs(com - was).max() < 0.04
    np.testing.assert_allclose(acceleration, found.omega**2 * (com - cop), atol=1e-9)
    np.testing.assert_allclose(np.gradient(com, STEP, axis=0), velocity, atol=1e-9)
    again = np.diff(com, 2, axis=0) / STEP**2
    np.testing.assert_allclose(again, acceleration[1:-1], atol=1e-6)
    # It was cut off in a step; the foot that swung then is down at the end.
    stances = [found.schedule.standing(side, found.duration - 1e-3) for side in SIDES]
    assert None not in stances


def test_a_swing_foot_is_lifted_where_its_sole_is_too_low_and_lands_in_time(walk):
    pendulum = Pendulum(walk)
    own, leg = SETTINGS.swing, pendulum.person.leg_length
    recorded = reference_of(walk_of(walk))
    found = with_clearance(recorded, leg, pendulum.person.of_side, own)
    same = with_clearance(recorded, leg, pendulum.person.of_side, replace(own, clearance=0.0))
    for i in range(len(SIDES)):
        mine = pendulum.person.of_side[i]
        stands = np.any(recorded.rows.contact[:, mine] > 0.5, axis=1)
        sole = recorded.rows.contact_position[:, mine, 2].min(axis=1)
        before, after, least = (r.rows.foot_position[:, i, 2] for r in (recorded, found, same))
        lift = after - before
        cycle = np.roll(np.arange(len(stands)), -np.flatnonzero(stands & ~np.roll(stands, 1))[0])
        swing, stance = cycle[~stands[cycle]], cycle[stands[cycle]]
        later = stance[round(own.lift_time / STEP) :]
        assert np.abs(lift[later]).max() < 1e-3, "a foot that stands stays where it is"
        landing = (sole + lift)[swing[-1]]
        assert landing == pytest.approx(-own.landing_depth * leg, abs=2e-3)
        middle = swing[len(swing) // 3 : 2 * len(swing) // 3]
        assert (sole + lift)[middle].min() > 0.9 * own.clearance * leg
        assert (lift >= least - before - 1e-12).all()
        rate = np.gradient(after, STEP)
        np.testing.assert_allclose(found.rows.foot_velocity[2:-2, i, 2], rate[2:-2], atol=0.02)


def test_the_first_step_lands_where_it_was_planned_and_is_drawn(begun):
    controller, world, state = begun
    (footfall,) = controller.footfalls
    assert world.fall is None and footfall.error < 0.08
    assert "pendulum" in {d.name for d in controller.drawings(state)}
    found = controller.summary()
    assert found.figures["landings"] == 1 == len(found.sentences)
    assert found.figures["recorded_speed_m_s"] == pytest.approx(1.2, rel=0.1)


def test_an_error_that_feet_cannot_correct_is_left_to_the_whole_body(begun):
    controller, _, state = begun
    reference, body = controller.reference, state.body
    ref, leg = reference.at(controller.gait.phase), controller.person.leg_length
    tasks = WalkingTasks(body.human, leg)
    foot = body.origins[controller.foot_bodies[0], :2] + [[-0.05, -0.03], [0.15, 0.03]]

    def pressure(error):
        """Return how far to the left the desired centre of pressure is [m]."""
        dcm_error, still = np.array([0.0, error * leg]), np.zeros(2)
        desired = tasks.com_acceleration(
            body, ref, 1.0, reference.omega, dcm_error, still, 0.0, foot, 0.0, still
        )
        off = (desired - ref.com_acceleration) / reference.omega**2
        return (ref.cop + body.com - ref.com - off)[1]

    farthest = foot[1, 1] + tasks.settings.max_cop_distance * leg
    assert foot[1, 1] < pressure(0.05) < pressure(0.07) < farthest
    assert pressure(0.5) == pytest.approx(farthest)


def test_a_descent_along_a_slope_is_not_braked(begun):
    controller, _, state = begun
    reference, body, still = controller.reference, state.body, np.zeros(2)
    ref, tasks = reference.at(controller.gait.phase), WalkingTasks(body.human, 0.9)
    foot, high = body.origins[controller.foot_bodies[0], None, :2], float(body.com[2] - 0.9)

    def vertical(slope, descent):
        """Return the desired vertical acceleration where a far footstep is below [m/s²]."""
        qvel = body.qvel.copy()
        qvel[2] -= body.com_velocity[2] + descent
        moved = body.moved_to(body.qpos, qvel)
        return tasks.com_acceleration(
            moved, ref, 1.0, reference.omega, still, still, 0.1, foot, high, slope, 0.1
        )[2]

    down = np.array([-0.3, 0.0])
    along = 0.3 * body.com_velocity[0]
    assert vertical(still, 0.6) > vertical(still, 0.1)
    assert vertical(down, along + 0.1) == pytest.approx(vertical(still, 0.1))


SIZE = np.array([0.2, 0.1])


@pytest.mark.parametrize(
    ("start", "end", "by"),
    [
        ((-0.5, 0.15), (0.5, 0.15), None),  # a step ahead
        ((-0.5, 0.15), (-0.3, -0.3), None),  # across behind the other one
        ((-0.5, 0.05), (0.5, 0.05), (0.0, 0.1)),  # through the other one
        ((-0.5, 0.0), (0.5, 0.0), (0.0, 0.1)),  # right through its middle
        ((-0.3, -0.2), (0.5, 0.15), (-1.0, 1.0)),  # through the leg: back on its own side first
        ((-0.3, 0.5), (0.3, -0.3), (1.0, 1.0)),  # across ahead: not before it has passed
        ((0.3, -0.3), (-0.3, -0.3), (0.0, 0.1)),  # from one side of the leg to the other
    ],
)
def test_a_foot_goes_around_the_other_one_on_its_own_side(start, end, by):
    start, end = np.array(start), np.array(end)
    points, around = detours(start, end[None], SIZE)
    assert around[0] == (by is not None)
    if by is None:
        return
    np.testing.assert_allclose((points / SIZE) ** 2 @ np.ones(2), 1.0)
    for own, sign in zip(points[0], by, strict=True):
        assert abs(own) < 1e-12 if sign == 0.0 else own * sign > 0.0


def test_a_bent_way_takes_as_much_acceleration_as_a_longer_straight_one():
    still, time = np.zeros(2), np.array([0.3])
    first, then = np.array([[0.3, 0.0]]), np.array([[0.0, 0.3]])
    assert bent_way(first, first, still, time)[0] == pytest.approx(0.6)  # one cubic
    bent = bent_way(first, then, still, time)[0]
    assert 0.6 < bent < bent_way(first, -first, still, time)[0]


def test_a_crossed_foot_reaches_its_place_without_meeting_the_other(begun):
    controller, _, _ = begun
    plan, leg = controller.plan, controller.person.leg_length
    for left, start, end in (
        (1.0, (-0.3, -0.2), (0.3, 0.6)),
        (-1.0, (-0.3, 0.2), (0.3, -0.6)),
        (1.0, (-0.3, 0.5), (0.35, -0.3)),
    ):
        at, goal = leg * np.array(start), leg * np.array(end)
        swing, step, time = SwingOffset(at), 0.005, 0.35
        pace, path = np.zeros(2), [at]
        while time > 0.0:
            by = plan.detour(left, at, goal, 0.2 * leg)
            swing.go(np.stack([at, pace]), np.zeros((2, 2)), goal, time, step, by)
            at, pace, time = swing.offset, swing.own[0], time - step
            path.append(at)
        assert np.linalg.norm(at - goal) < 0.05 * leg
        x, y = (np.array(path) / leg * [1.0, left]).T
        ahead, sideways = plan.person.sole.clear_way / leg
        assert ((x / ahead) ** 2 + (y / sideways) ** 2).min() > 0.8
        assert (y[1:][x[1:] * x[:-1] < 0.0] > 0.0).all()  # passes on its own side


def test_a_push_is_estimated_in_addition_to_ground_forces(walk, world_of):
    controller = Pendulum(walk)
    world = world_of(controller)
    state, estimated = world.reset(), []
    push, trunk = np.array([30.0, 120.0, 0.0]), walk.human.body("torso")
    while world.time < 0.7:  # double and single support, a foot that lands
        if world.time > 0.3:
            world.push(trunk, push)
        state = world.step(controller(state))
        estimated.append(controller.disturbance.acceleration)
    own, deadband = push[:2] / state.body.mass, controller.settings.disturbance.deadband
    seen = np.abs(estimated[10:59]).max(axis=1) > 0.3
    assert seen.sum() <= 2  # of 49 ticks: 10 ms, where a foot strikes hard
    late = np.array(estimated[70:])
    assert np.abs(np.median(late, axis=0) - own).max() < deadband
    wrong = np.abs(late - own).max(axis=1) > 2.0 * deadband
    assert wrong.sum() <= 5  # of 70 ticks


def test_an_estimated_disturbance_is_no_turn_of_the_axes_and_no_single_shock(walk):
    estimator, angle, step = DisturbanceEstimator(DisturbanceSettings()), 0.01, 0.005
    still, nothing = BodyState(walk.human, walk.human.standing()), np.zeros((1, 3))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    velocity = np.array([1.3, 0.0])
    for k in range(20):
        qvel = np.zeros(walk.human.model.nv)
        qvel[:2] = velocity
        body = BodyState(walk.human, still.qpos, qvel)
        shock = np.array([[0.0, 900.0, 0.0]]) if k % 5 == 0 else nothing
        estimator.update(body, shock, step, turn)
        velocity = turn @ velocity
        np.testing.assert_allclose(estimator.acceleration, 0.0, atol=1e-6)


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.02])
def test_noisy_velocities_are_no_disturbance_and_hide_none(walk, noise):
    settings = DisturbanceSettings()
    estimator, step, ground = DisturbanceEstimator(settings), 0.005, np.zeros((1, 3))
    body, random = BodyState(walk.human, walk.motion.qpos[0]), np.random.default_rng(1)
    still, moving, found = np.zeros(walk.human.model.nv), np.zeros(walk.human.model.nv), []
    for k in range(400):
        moving[:2] = noise * random.standard_normal(2)
        moving[0] += 3.0 * step * min(max(k - 300, 0), 60)  # pushed for 0.3 s by 3 m/s²
        estimator.update(body.moved_to(walk.motion.qpos[0], still + moving), ground, step)
        found.append(estimator.acceleration.copy())
    found = np.array(found)
    assert np.mean(np.abs(found[20:300]).max(axis=1) > 0.0) < 0.02
    felt = found[300 + settings.n_noisy_samples : 360]
    np.testing.assert_allclose(felt.mean(axis=0), [3.0, 0.0], atol=0.5)


def test_a_foot_that_goes_its_own_way_moves_smoothly_whatever_the_motion_does():
    def motion(t):
        """Return place and velocity of a foot of the motion, which hurries [m, m/s]."""
        return np.array([0.3 * np.sin(7.0 * t), 0.1]), np.array([2.1 * np.cos(7.0 * t), 0.0])

    goal, step = np.array([0.5, -0.3]), 0.005
    swing, places = SwingOffset(np.zeros(2)), []
    foot = np.array(motion(0.0))
    for k in range(60):
        places.append(foot[0])
        swing.go(foot, np.array(motion(k * step)), goal, 0.3 - k * step, step)
        pace, _ = swing.own
        foot = np.array([motion(k * step)[0] + swing.offset, pace])
    assert np.abs(places[-1] - goal).max() < 0.02 and np.abs(pace).max() < 0.5
    bends = np.diff(places, 2, axis=0) / step**2
    assert np.linalg.norm(bends, axis=1).max() < 62.0  # its own 60 m/s², and rounding
    swing.lead(np.zeros(2), 0.3, step)
    assert swing.own is None  # along with the motion again


def test_a_foot_that_is_held_up_is_led_no_farther():
    swing, held, step = SwingOffset(np.zeros(2)), np.array([[0.1, 0.2], [0.0, 0.0]]), 0.005
    for k in range(60):
        swing.go(held, np.zeros((2, 2)), np.array([0.9, 0.0]), 0.3 - k * step, step)
        assert np.abs(swing.offset - held[0]).max() < 0.01


def test_a_command_holds_for_a_tick_unless_a_sole_touches_or_leaves():
    hold, up, down = (
        CommandHold(0.02, 0.005, 8),
        np.zeros(3, dtype=bool),
        np.array([True, False, False]),
    )
    stands = [True, False]
    assert [hold.still_holds(up, stands) for _ in range(6)] == [
        False,
        True,
        True,
        True,
        False,
        True,
    ]
    assert not hold.still_holds(down, stands)  # at once, and a whole tick begins
    assert [hold.still_holds(down, stands) for _ in range(4)] == [True, True, True, False]
    assert not hold.still_holds(down, [True, True])
    qacc = np.arange(8.0)
    hold.keep(StablePD(np.zeros(2), np.ones(2), torque=np.full(2, 7.0)), qacc)
    hold.next()
    later = hold.next()
    np.testing.assert_allclose(later.velocity, 1.0 + 0.01 * qacc[6:])
    np.testing.assert_array_equal(later.torque, 7.0)
    assert CommandHold(0.001, 0.005, 8).samples == 1


def test_a_walk_with_a_tick_of_20_ms_lands_its_step_with_a_third_of_the_programs(walk, world_of):
    controller = Pendulum(walk, settings=PendulumSettings(tick=0.02))
    assert controller.rates.control == 100.0 == 0.5 * Pendulum(walk).rates.control
    world = world_of(controller)
    state, torques = world.reset(), set()
    while world.time < 0.6:
        command = controller(state)
        torques.add(command.torque.tobytes())
        state = world.step(command)
    assert 30 <= len(torques) < 48 and world.fall is None
    assert controller.footfalls[0].error < 0.08
    assert controller.summary().figures["speed_m_s"] == pytest.approx(1.2, rel=0.15)


@pytest.mark.slow
def test_a_recorded_walk_goes_on_at_its_speed_after_a_push(data):
    push = Push(force=80.0, duration=0.2, direction=np.pi / 2, time=1.0)
    path = data / "cmu_asfamc" / "07_01.amc"
    run = simulate(path, controller="pendulum", duration=3.0, disturbances=(push,))
    assert run.status == "ok"
    figures = run.figures
    assert figures["speed_m_s"] == pytest.approx(figures["recorded_speed_m_s"], rel=0.1)
    assert abs(figures["aside_m"]) < 0.4 and figures["landings"] >= 5
    knees = [run.record.motion[f"knee_angle_{side}"] for side in SIDES]
    assert np.min(knees) > np.radians(-6.0)  # hyperextended to -16 before knees resisted
    solved = run.record.signals["controller.solved"]
    assert np.all(solved == 1.0)


def test_another_law_ground_or_person_is_refused(walk):
    with pytest.raises(ParameterError, match="no landing law 'moon'; there are divergent"):
        PendulumSettings(law="moon")
    with pytest.raises(ParameterError, match="tick=0 s must be above 0 and at most 0.02 s"):
        PendulumSettings(tick=0.0)
    with pytest.raises(ParameterError, match="recorded on level ground"):
        Pendulum(replace(walk, ground=Ground(slope=0.1)))
    motion = walk_of(walk).motion
    qpos = motion.qpos.copy()
    qpos[:, 2] += np.where(np.arange(len(qpos)) > len(qpos) // 2, 0.2, 0.0)  # upstairs
    with pytest.raises(ParameterError, match=r"feet of this walk stand at heights \d+ cm apart"):
        Pendulum(replace(walk, motion=replace(motion, qpos=qpos)))
    other = World(Human.create(1.7, 65.0, joints="66"), recording=False)
    with pytest.raises(ParameterError, match="degrees of freedom"):
        Pendulum(walk)(other.reset())


def test_a_spin_on_a_foot_is_refused():
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    time = np.linspace(0.0, 2.0, 101)

    def spinning(angle):
        """Return somebody who turns on the spot by an angle [rad]."""
        qpos = np.tile(human.standing(), (len(time), 1))
        for row, share in zip(qpos, time / time[-1], strict=True):
            row[3:7] = turned(row[3:7], angle * share)
        qvel = np.zeros((len(time), human.model.nv))
        return Record(human, Motion(time, qpos, qvel, human.joint_names))

    Pendulum(spinning(1.5))
    with pytest.raises(ParameterError, match="turns by 200°"):
        Pendulum(spinning(np.radians(200.0)))


def test_a_foot_is_lifted_over_what_is_in_its_way_and_led_down_to_where_it_lands():
    own = Foot("l", 1, False, touchdown=0.4, lift_off=0.0)
    goal, still = np.array([0.6, 0.0]), np.zeros(3)

    def heights(level):
        path = SwingPath(
            0.9, SoleShape(heel=-0.07, heel_centre=-0.05, ball=0.15, toes=0.216, half_width=0.04)
        )
        path.start(np.zeros(3))
        found = []
        for u in np.linspace(0.0, 1.0, 401):
            place = np.array([0.6 * u, 0.0, 0.0])
            pace = still + [0.6 / 0.4, 0.0, 0.0]
            found.append(path.height(own, 0.4 * u, 1.0, place, pace, goal, level, None))
        return np.array(found).T

    high, speed = heights(lambda place: 0.1 if 0.3 < place[0] < 0.5 else 0.0)
    assert high[0] == high[-1] == 0.0
    assert high[160:260].min() > 0.1  # toes are over the edge before the ankle is
    # The speed of the rise is an input: without it the reaction is late.
    np.testing.assert_allclose(np.gradient(high, 0.001)[2:-2], speed[2:-2], atol=0.06)
    up, _ = heights(lambda place: 0.1 if place[0] > 0.5 else 0.0)
    assert up[-1] == pytest.approx(0.1) and up[200] > 0.095
    slope, rises = heights(lambda place: 0.1 * place[0])
    np.testing.assert_allclose(slope[[0, -1]], [0.0, 0.06])
    plane, _ = heights(lambda place: 0.0)
    np.testing.assert_allclose(slope - plane, np.linspace(0.0, 0.06, 401), atol=1e-9)


def test_a_foot_beyond_its_leg_comes_nearer_to_the_hip_at_the_height_it_is_to_have():
    hip, goes = np.array([0.1, 0.05, 0.9]), np.array([1.0, 0.0, 0.0])
    place, pace, push = np.array([0.7, 0.05, 0.1]), np.array([3.0, 0.5, -1.0]), np.full(3, 2.0)
    limit_to_reach(0.99 * 0.9, hip, goes, place, pace, push, 30.0)
    assert np.linalg.norm(place - hip) == pytest.approx(0.99 * 0.9)
    assert place[1:] == pytest.approx([0.05, 0.1])
    # It goes along with the hip, and aside and down as before.
    assert pace == pytest.approx([1.0, 0.5, -1.0])
    assert push == pytest.approx([0.0, 2.0, 2.0])
    near = np.array([0.3, 0.05, 0.1]), np.array([3.0, 0.5, -1.0]), np.full(3, 2.0)
    kept = [each.copy() for each in near]
    limit_to_reach(0.99 * 0.9, hip, goes, *near, 30.0)
    np.testing.assert_array_equal(near, kept)


def test_a_foot_stops_at_the_reach_of_its_leg_without_a_jump_of_its_velocity():
    hip, still, speeds = np.array([0.0, 0.0, 0.9]), np.zeros(3), []
    for ahead in np.linspace(0.3, 0.45, 301):
        place, pace = np.array([ahead, 0.0, 0.1]), np.array([1.5, 0.0, 0.0])
        limit_to_reach(0.99 * 0.9, hip, still, place, pace, np.zeros(3), 30.0)
        speeds.append(pace[0])
    assert speeds[0] == 1.5 and speeds[-1] == 0.0
    assert np.abs(np.diff(speeds)).max() < 0.2
