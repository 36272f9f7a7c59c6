"""Walks at other speeds, along other ways, that stop and start."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.contact.ground import Ground
from plantigrade.contact.relief import Bump
from plantigrade.control.gait.reference import reference_of
from plantigrade.control.pendulum import WalkCommand, Walker, walk_of
from plantigrade.control.pendulum.crouch import Crouch, CrouchSettings
from plantigrade.control.pendulum.frame import HeadingFrame, ObservedState, Terrain
from plantigrade.control.pendulum.path import PathSettings, depths_of, path_of, speeds_of
from plantigrade.control.pendulum.reference import ScaledReference
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.workflows.simulate import simulate
from plantigrade.world import World


def test_longer_and_quicker_steps_keep_the_pendulum_true(walk):
    recorded = reference_of(walk)
    paced = ScaledReference(recorded)
    assert paced.speed == pytest.approx(1.2, rel=0.1)
    before = paced.at(0.5).com.copy()
    paced.scale(1.3, 1.1, 0.5)
    # Nothing jumps but the step, which is as much longer about the mean place.
    assert paced.at(0.5).com == pytest.approx(before, abs=0.02)
    now, own = paced.at(0.7), recorded.at(0.7)
    assert now.com_velocity == pytest.approx(own.com_velocity * [1.43, 1.1, 1.1])
    assert now.foot_acceleration == pytest.approx(own.foot_acceleration * [1.573, 1.21, 1.21])
    # What moves the mass is its distance from the pressure, by the cadence squared.
    off, was = ((x.com - x.cop)[:2] for x in (now, own))
    assert off == pytest.approx(was * [1.573, 1.21])
    paced.scale(0.5, 1.0, 0.9)
    stride = paced.at(0.9 + paced.period).com - paced.at(0.9).com
    assert stride[0] == pytest.approx(0.5 * recorded.advance[0])
    # Feet are as far behind the mass on average as the posture has them, whatever the step.
    times = np.linspace(0.9, 0.9 + recorded.period, 50)
    behind = [
        np.mean([x.at(t).foot_position[:, 0] - x.at(t).com[0] for t in times])
        for x in (paced, recorded)
    ]
    assert behind[0] == pytest.approx(behind[1], abs=0.003)
    assert abs(behind[1]) > 0.03


def test_words_of_speed_and_way_are_read_and_bad_ones_refused():
    found = speeds_of("1.2,0.8@5,0@10")
    assert [found.at(t) for t in (0.0, 4.9, 5.0, 12.0)] == [1.2, 1.2, 0.8, 0.0]
    for word in ("fast", "1.2@3", "1.2,0.8", "1.2,1@5,2@3", "-1", "nan"):
        with pytest.raises(ParameterError, match="speed"):
            speeds_of(word)
    way = path_of("bearing:0,90@5")
    assert way.heading(4.0, 7.0, 1.0) == 0.0 and way.heading(5.0, 0.0, 0.0) == pytest.approx(
        np.pi / 2
    )
    assert path_of("straight").heading(9.0, 1.0, 2.0) == 0.0
    with pytest.raises(ParameterError, match="as its times must rise"):
        speeds_of("1,0@5,1@3")
    for word in ("left", "bearing:", "bearing:x", "points:1,2/3", "points:", "points:1,inf"):
        with pytest.raises(ParameterError, match="write straight; bearing:DEG"):
            path_of(word)
    for word in ("points:1e300,0", "points:" + "1,1/" * 1000 + "2,2"):
        with pytest.raises(ParameterError, match="at most"):
            path_of(word)


def test_a_way_through_points_is_come_back_to_and_ends_at_the_last():
    way = path_of("points:4,0/4,3")
    assert way.heading(0.0, 1.0, 0.0) == pytest.approx(0.0)
    assert way.heading(0.1, 1.0, 0.3) < -0.2  # beside it: back to it, not straight to the corner
    assert way.heading(0.2, 3.95, 0.0) == pytest.approx(np.pi / 2, abs=0.2)
    assert way.heading(0.3, 1.0, 0.0) > 0.15  # what was passed is not walked to again
    assert way.heading(0.4, 4.0, 3.01) is None
    assert way.started(PathSettings()).heading(0.0, 1.0, 0.0) == pytest.approx(0.0)


def test_the_speed_limit_falls_before_corners_and_for_turning_round():
    way = path_of("points:6,0/6,4/6,0")
    assert way.heading(0.0, 0.0, 0.0) == 0.0
    before = [way.speed_limit(x, 0.0, 0.0) for x in (0.0, 2.0, 3.0, 4.4)]
    assert before == sorted(before, reverse=True) and before[0] > 1.5 and before[-1] < 1.0
    assert way.heading(0.1, 5.5, 0.0) is not None and way.passed == 1
    turned = [way.speed_limit(6.0, 0.5, angle) for angle in (0.0, 0.8, 1.4)]  # round the corner
    assert turned == sorted(turned) and turned[0] == pytest.approx(0.3)
    assert way.speed_limit(6.0, 2.5, 0.5 * np.pi) < 0.8  # it turns round at the next
    # Beside the way, towards its end, there must be room to come back.
    assert way.speed_limit(4.5, 1.5, 0.5 * np.pi) < way.speed_limit(5.5, 1.5, 0.5 * np.pi)
    assert path_of("points:-3,0").speed_limit(0.0, 0.0, 0.0) == pytest.approx(0.3)
    assert path_of("bearing:0,90@5").speed_limit(0.0, 0.0, 3.0) == np.inf


@pytest.mark.parametrize("word", ["points:4,0/4,2", "points:-2,0"])
def test_corners_are_walked_round_and_points_behind_are_reached(walk, world_of, word):
    led = Walker(walk, WalkCommand(path=path_of(word)))
    world = world_of(led)
    state = world.reset()
    while (
        world.fall is None
        and world.time < 30.0
        and (led.walking or world.time < led.stops[0][0] + 2.0)
    ):
        state = world.step(led(state))
    assert world.fall is None and not led.walking
    assert state.body.com[:2] == pytest.approx(led.command.path.points[-1], abs=1.2)
    assert led.command.path.passed == len(led.command.path.points) - 1


def test_how_far_a_walk_is_from_its_way_is_measured_in_the_world():
    way = path_of("points:4,0/4,3")
    assert way.deviation(2.0, 0.5) == pytest.approx(0.5) and way.deviation(
        5.0, 0.0
    ) == pytest.approx(1.0)
    assert way.deviation(4.0, 2.0) == pytest.approx(2.0)  # that part of it is still to come
    assert way.heading(0.1, 3.9, 0.0) is not None and way.passed == 1
    assert way.deviation(6.0, 2.0) == pytest.approx(2.0)
    assert way.heading(0.2, 4.0, 3.0) is None and way.passed == 2
    assert path_of("bearing:0,90@5").deviation(1.0, 2.0) is None


def test_a_walk_that_cuts_a_corner_or_overshoots_it_says_so(walk, world_of):
    led = Walker(walk, WalkCommand(path=path_of("points:1,0/1,4")))
    world = world_of(led)
    state = world.step(led(world.reset()))
    led.command.path.heading(0.1, 0.9, 0.0)
    led.frame.shift(0.7)  # 0.7 m aside of all of it
    led(state)
    assert led.summary().figures["astray_max_m"] == pytest.approx(0.7, abs=0.15)


def test_a_point_where_the_walk_is_already_is_no_part_of_its_path():
    for word in ("points:0,0", "points:0,0/0,0"):
        assert path_of(word).heading(0.0, 0.5, 0.0) is None  # it stands
    way = path_of("points:0,0/4,0/4,0/4,3")
    assert way.points == ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0))


def test_a_frame_shows_the_world_as_it_is_from_there(walk):
    frame, motion = HeadingFrame(), walk.motion
    frame.steer(1.0, 0.2, 0.7)
    frame.shift(0.3)
    assert frame.to_world(np.array([1.0, -0.1, 0.0])) == pytest.approx([1.0, 0.2, 0.0])
    points = np.array([[0.3, -2.0, 0.5], [1.0, 1.0, 0.0]])
    assert frame.to_walk(frame.to_world(points)) == pytest.approx(points)
    ground = Ground(slope=0.1, bumps=(Bump((0.6, 0.1, -0.9), 1.0),))
    world = World(walk.human, ground, recording=False, qpos=motion.qpos[0], qvel=motion.qvel[0])
    state = world.reset()
    seen, own = ObservedState(state, frame).body, world.reset().body
    assert seen.com == pytest.approx(frame.to_walk(own.com))
    assert frame.turn @ seen.com_velocity == pytest.approx(own.com_velocity)
    assert seen.angular_momentum @ frame.turn.T == pytest.approx(own.angular_momentum)
    under = Terrain(world, frame)
    up = under.normal_at(points)
    assert up @ frame.turn.T == pytest.approx(ground.normal_at(frame.to_world(points)))
    gap = points @ under.normal - under.under(points)
    there = frame.to_world(points)
    assert gap == pytest.approx(there @ ground.normal - ground.under(there))


def test_a_walk_is_not_led_beyond_what_it_can(walk):
    with pytest.raises(ParameterError, match="name a faster walk"):
        Walker(walk, WalkCommand(speed=speeds_of("1.0,2.5@3")))
    part = walk.motion.frames(np.arange(walk.motion.n_frames // 3))
    with pytest.raises(ParameterError, match="walk that is repeated"):
        Walker(walk_of(replace(walk, motion=part)), WalkCommand(speed=speeds_of("1.0")))
    with pytest.raises(ParameterError, match="no effect without controller=pendulum"):
        simulate(speed="1.0")


def test_a_crouch_lowers_head_and_mass(walk):
    human, crouch = walk.human, Crouch.of(walk.human, CrouchSettings(max_depth_cm=25.0))
    stands, bent = BodyState(human, human.standing()), np.array(human.standing())
    bent[7:] += crouch.angles
    low = stands.moved_to(bent)
    ankle = 0.5 * sum(low.origin(f"foot_{s}")[2] for s in "rl")  # the pelvis is where it was
    head = stands.origin("head")[2] - (low.origin("head")[2] - ankle)
    head -= 0.5 * sum(BodyState(human, human.standing()).origin(f"foot_{s}")[2] for s in "rl")
    assert head == pytest.approx(0.25, abs=0.08)
    paced = ScaledReference(reference_of(walk))
    before = paced.at(0.3).com[2]
    paced.crouch = crouch
    assert before - paced.at(0.3).com[2] == pytest.approx(crouch.lowering)
    with pytest.raises(ParameterError, match="stoop must be 0–30 cm"):
        depths_of("0,90@3")


@pytest.mark.slow
def test_a_walk_turns_stands_and_goes_on(data):
    run = simulate(
        data / "cmu_asfamc" / "16_15.amc",
        controller="pendulum",
        speed="1.0,0@4,0.9@7",
        path="bearing:0,30@1",
        duration=11.0,
    )
    assert run.status == "ok"
    assert "controller pendulum, speed 1.0,0@4,0.9@7, path bearing:0,30@1." in run.sentence
    followed = run.record.references["motion"]
    assert followed.duration > run.record.motion.duration - 1e-6, "its pale figure stood still"
    assert 0.0 < np.diff(followed.qpos[:, 0]).max() < 0.05 and np.diff(followed.time).min() > 0.0
    motion = run.record.motion
    at = {t: motion.at(np.array([t])).qpos[0, :2] for t in (2.5, 4.0, 6.5, 7.0, 10.0, 11.0)}
    way = at[4.0] - at[2.5]
    assert np.rad2deg(np.arctan2(way[1], way[0])) == pytest.approx(30.0, abs=10.0)
    assert np.linalg.norm(at[7.0] - at[6.5]) < 0.04  # it stands; its legs straighten
    assert np.linalg.norm(at[11.0] - at[10.0]) > 0.5
    assert 0.5 < run.figures["stood_s"] < 4.5
