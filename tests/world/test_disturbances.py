"""Ropes, boxes, ground that moves, pushes at a phase: they do what mechanics says."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.check import check
from plantigrade.contact.ground import Ground
from plantigrade.control import Posture
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.pages.scene import build_scene
from plantigrade.record.moving_ground import GroundPath
from plantigrade.world import (
    Box,
    FloorShift,
    PhasePush,
    Push,
    Rope,
    ThrownBox,
    Tilting,
    World,
    standing_on,
)
from plantigrade.world.box import PARKING_HEIGHT
from plantigrade.world.disturbance import StrikeTimer
from plantigrade.world.grounds import ground_named, platform_named
from plantigrade.world.recorded_wrench import RecordedWrench, recorded_wrenches
from tests.world.yielding import yielding

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")


def world(*disturbances, **options) -> World:
    return World(HUMAN, disturbances=disturbances, **{"rate": 300.0, **options})


def test_a_rope_pulls_towards_its_anchor_while_it_pulls():
    anchor = (0.0, 3.0, 1.2)
    record = world(Rope(force=30.0, anchor=anchor, time=0.1, duration=0.1)).simulate(Posture(), 0.3)
    force = record.signals["world.push"]
    pulling = (record.motion.time > 0.099) & (record.motion.time < 0.199)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 30.0 * pulling, atol=1e-9)
    way = np.array(anchor) - record.contact_point[pulling, -1]
    assert np.abs(np.cross(force[pulling], way)).max() < 0.01 and (force[pulling, 1] > 29).all()
    assert check(record).measures["root_moment"].value < 0.05


def test_forces_of_a_recorded_motion_act_again_at_their_point_and_time():
    first = world(Push(force=40.0, duration=0.1, time=0.1)).simulate(Posture(), 0.3)
    (wrench,) = recorded_wrenches(first)
    again = world(wrench).simulate(Posture(), 0.3)
    pushed, repeated = (each.signals["world.push"][:, 0] for each in (first, again))
    dt = np.diff(first.motion.time)
    np.testing.assert_allclose(repeated[1:] @ dt, pushed[1:] @ dt, rtol=0.1)  # within one tick
    assert check(again).measures["root_moment"].value < 0.05
    assert not recorded_wrenches(world().simulate(Posture(), 0.05))


def test_a_recorded_moment_turns_and_does_not_push():
    (wrench,) = recorded_wrenches(
        world(Push(force=40.0, duration=0.2, time=0.0)).simulate(Posture(), 0.2)
    )
    turn = RecordedWrench(
        site=wrench.site,
        times=wrench.times,
        force=np.zeros_like(wrench.force),
        moment=np.tile([3.0, -4.0, 12.0], (len(wrench.times), 1)),
        period=0.1,
    )
    pushed = world(turn)
    pushed.step(Posture()(pushed.reset()))
    arms = pushed.pushes[:, 0] - pushed.data.xipos[pushed.human.body(wrench.site.body)]
    np.testing.assert_allclose(np.cross(arms, pushed.pushes[:, 1]).sum(axis=0), [3, -4, 12])
    np.testing.assert_allclose(pushed.pushes[:, 1].sum(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "word", "said"),
    [
        (Rope, "80,2,0", "NEWTON,X,Y,Z"),
        (Rope, "-80,2,0,1,0", "only pulls"),
        (ThrownBox, "2,5,left,1", "KG,M_PER_S"),
        (ThrownBox, "2,0.5,0,1", "0 .dropped. or from 2 to 50"),
        (ThrownBox, "-2,5,0,1", "mass must be"),
        (FloorShift, "0.1,0.2,0", "METRES,SECONDS"),
        (FloorShift, "0.1,0,0,1", "duration must be 0.02"),
    ],
)
def test_a_word_that_is_none_is_refused_with_how_to_write_it(kind, word, said):
    with pytest.raises(ParameterError, match=said):
        kind.parse(word)


def test_words_are_what_they_say():
    rope = Rope.parse("80,2,0,1,0.5,0.25")
    assert (rope.force, rope.anchor, rope.time, rope.duration) == (80.0, (2.0, 0.0, 1.0), 0.5, 0.25)
    assert Rope.parse("80,2,0,1,0.5").duration == np.inf
    shift = FloorShift.parse("0.1,0.2,90,1")
    np.testing.assert_allclose(shift.position(2.0), [0.0, 0.1, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(("word", "way"), [("2,6,180,0.05", [-1, 0]), ("2,5,90,0.05", [0, 1])])
def test_a_thrown_box_meets_the_trunk_and_pushes_it_on(word, way):
    """In the direction of its flight, where and when it should: 1.5 m at its speed."""
    box = ThrownBox.parse(word)
    record = world(box).simulate(Posture(), 0.5)
    push = record.signals["world.push"]
    first = int(np.flatnonzero(np.linalg.norm(push, axis=1))[0])
    meets = box.time + (1.5 - 0.25) / box.speed  # box and chest are not points
    assert record.motion.time[first] == pytest.approx(meets, abs=0.06)
    assert push[:, :2].sum(axis=0) @ way > 0.9 * np.linalg.norm(push[:, :2].sum(axis=0))
    hit = next(site for site in record.sites if site.part == "push")
    assert hit.body in ("torso", "humerus_r")  # from the right it meets the arm


def test_a_dropped_box_falls_on_the_head():
    record = world(ThrownBox.parse("1,0,0,0.1")).simulate(Posture(), 0.6)
    hit = [site.body for site in record.sites if site.part == "push"]
    push = record.signals["world.push"]
    first = int(np.flatnonzero(np.linalg.norm(push, axis=1))[0])
    assert hit[0] == "head" and push[first, 2] < 0
    falls = np.sqrt(2 * 0.5 / 9.81)
    assert record.motion.time[first] == pytest.approx(0.1 + falls, abs=0.04)


@pytest.mark.parametrize(
    "plate",
    [
        Tilting(amplitude=0.08, period=1.0),
        Tilting(amplitude=0.05, period=1.0, direction=np.pi / 2),
        FloorShift(distance=0.1, duration=0.3, time=0.1),
    ],
)
def test_the_checker_looks_along_ground_that_moves(plate):
    """Feet that go with a plate neither slip nor sink, lift off nor need more friction."""
    record = world(plate, rate=600.0).simulate(Posture(), 0.8)
    found = check(record).measures
    for quantity in ("hover", "slip", "friction", "adhesion"):
        assert not found[quantity].bad, quantity
    assert found["penetration"].value < yielding(record)
    at_rest = {k: v for k, v in record.signals.items() if k != "ground.place"}
    measures = check(replace(record, signals=at_rest)).measures
    assert measures["slip"].bad or measures["penetration"].bad
    moved = GroundPath.of(record)
    assert moved is not None
    np.testing.assert_allclose(np.linalg.det(moved.rotation), 1.0)
    scene = build_scene(record)
    assert scene.plate and scene.positions.shape[1] == HUMAN.model.nbody + 1
    np.testing.assert_allclose(scene.positions[-1, -1], moved.shift[-1], atol=0.01)
    assert not build_scene(replace(record, signals=at_rest)).plate


def test_a_box_brings_its_momentum():
    """A box thrown at a person in the air: what one loses the other gains."""
    box = Box(position=(0.8, 0.0, 2.2), velocity=(-5.0, 0.0, 0.0), time=0.05, mass=3.0)
    thrown = world(box, passive=False, recording=False)
    thrown.model.opt.gravity[:] = 0.0
    qpos = standing_on(HUMAN, Ground())
    qpos[2] += 1.0
    state = thrown.reset(qpos=qpos, qvel=np.zeros(HUMAN.model.nv))
    place = slice(HUMAN.model.nv, HUMAN.model.nv + 3)
    for _ in range(5):
        state = thrown.step()
    assert not state.body.com_velocity.any()
    for _ in range(35):
        state = thrown.step()
    gained = HUMAN.mass * state.body.com_velocity
    lost = 3.0 * (np.array(box.velocity) - thrown.data.qvel[place])
    assert gained[0] < -5.0
    np.testing.assert_allclose(gained, lost, atol=0.02)


def test_of_two_equal_boxes_each_waits_and_flies():
    thrown = world(*(ThrownBox(speed=5.0, time=0.1) for _ in range(2)), recording=False)
    thrown.reset()
    while thrown.time < 0.1:
        thrown.step()
    heights = [thrown.data.body(f"box_{i}").xpos[2] for i in range(2)]
    np.testing.assert_allclose(heights, PARKING_HEIGHT, atol=0.01)
    for _ in range(5):
        thrown.step()
    assert max(thrown.data.body(f"box_{i}").xpos[2] for i in range(2)) < 2.0


def test_what_a_box_does_is_in_the_record_and_no_fall():
    box = Box(position=(0.0, 0.0, 1.95), time=0.02, mass=1.0, size=(0.15, 0.15, 0.15))
    made = world(box)
    record = made.simulate(Posture(), 0.3)
    hit = record.signals["world.push"]
    assert hit[:, 2].min() < -20.0 and made.fall is None
    assert "push_head" in [site.name for site in record.sites]
    assert check(record).measures["root_force"].value < 0.05


def test_a_moving_floor_moves_a_standing_person():
    record = world(FloorShift(distance=0.05, duration=0.3, time=0.05)).simulate(Posture(), 0.6)
    np.testing.assert_allclose(record.signals["ground.place"][-1], [0.05, 0, 0, 0], atol=1e-4)
    heel = [i for i, site in enumerate(record.sites) if "heel" in site.name]
    moved = record.contact_point[-1, heel, 0] - record.contact_point[2, heel, 0]
    np.testing.assert_allclose(moved, 0.05, atol=0.004)
    assert any("ground moved" in note for note in record.notes)
    assert check(record).measures["root_force"].value < 0.1


@pytest.mark.parametrize("direction", [0.0, np.pi / 2])
def test_a_plate_tilts_as_specified(direction):
    plate = Tilting(amplitude=0.06, period=1.0, direction=direction)
    assert plate.position(1.25)[2:] == pytest.approx(
        [0.06 * np.cos(direction), 0.06 * np.sin(direction)]
    )
    swaying = world(plate, recording=False)
    hold, state = Posture(), swaying.reset()
    while swaying.time < 0.25:
        state = swaying.step(hold(state))
    place = swaying.data.qpos[HUMAN.model.nq : HUMAN.model.nq + 4]
    np.testing.assert_allclose(place, plate.position(swaying.time), atol=2e-4)
    level = swaying.data.geom("floor_plate").xmat.reshape(3, 3)
    expected = {0.0: level[2, 0], np.pi / 2: level[2, 1]}[direction]
    assert expected > 0.005  # up in front, or on the left
    assert sum(state.foot_force(side)[2] for side in "rl") > 300.0


def test_ground_that_moves_must_be_level_and_alone():
    tilting = Tilting(amplitude=0.1)
    for ground, disturbances in (
        (ground_named("slope:5"), (tilting,)),
        (ground_named("dome:1"), (tilting,)),
        (Ground(), (tilting, FloorShift(distance=0.1))),
    ):
        with pytest.raises(ParameterError, match="level"):
            World(HUMAN, ground, disturbances, rate=300.0)


def test_a_push_at_a_phase_waits_for_two_strikes():
    push = PhasePush(force=10.0, duration=0.1, side="l", phase=0.25)
    timer = StrikeTimer()
    for i in range(400):  # strikes at 0.4, 1.4, 2.4 s; what lifts for a moment is no step
        time = 0.01 * i
        load = 0.0 if time % 1.0 < 0.4 or 0.7 < time % 1.0 < 0.75 else 0.9
        if timer.push_time is None:
            timer.update(time, load, push)
    assert timer.push_time == pytest.approx(1.4 + 0.25 * 1.0, abs=0.011)
    word = Push.parse("10,0.1,90,l25")
    assert word == PhasePush(force=10.0, duration=0.1, direction=np.pi / 2, side="l", phase=0.25)
    stands = world(push, rate=300.0)
    assert "world.push" not in stands.simulate(Posture(), 0.2).signals
    assert push.missed(stands) == (
        "The push at 25 % of the gait cycle of the left foot never came: it needs two heel strikes "
        "of that foot."
    )
    stands.memory[push].push_time = 0.1
    assert not push.missed(stands)
    stands.memory[push].push_time = 0.3  # later than the end
    assert push.missed(stands)


def test_grounds_that_tilt_by_name():
    assert platform_named("flat") is None
    assert platform_named("tilting:5") == Tilting(amplitude=np.deg2rad(5.0))
    side = platform_named("tilting:5,2,90")
    assert side == Tilting(amplitude=np.deg2rad(5.0), period=2.0, direction=np.deg2rad(90.0))
    for word in ("tilting", "tilting:x", "tilting:60", "tilting:5,0", "tilting:5,4,nan"):
        with pytest.raises(ParameterError, match="tilt"):
            platform_named(word)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Rope(force=-1.0, anchor=(0.0, 0.0, 0.0)),
        lambda: Box(position=(0.0, 0.0, np.nan)),
        lambda: Box(position=(0.0, 0.0, 1.0), mass=0.0),
        lambda: FloorShift(distance=0.1, duration=0.0),
        lambda: PhasePush(force=1.0, duration=1.0, side="x"),
        lambda: PhasePush(force=1.0, duration=1.0, phase=2.0),
    ],
)
def test_what_is_no_disturbance_is_refused(make):
    with pytest.raises(ParameterError):
        make()
