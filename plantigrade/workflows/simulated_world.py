"""The world in which a person is simulated: what acts on them, their initial state, the rates."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, spread
from plantigrade.control import Posture
from plantigrade.control.choices import STANDING, settings_among
from plantigrade.control.gait.reference import period_of
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.simulation_start import Start
from plantigrade.world import (
    Barrier,
    Controller,
    Disturbance,
    FloorShift,
    InitialState,
    Load,
    Push,
    Rope,
    ThrownBox,
    World,
    world_for,
)
from plantigrade.world.grounds import ground_named, platform_named
from plantigrade.world.model_mismatch import ModelMismatch
from plantigrade.world.recorded_wrench import recorded_wrenches
from plantigrade.world.world import CONTROL_RATE, RATE

SETTLING_TIME = 1.0
"""Time for which a person stands before the first frame, until soles and springs rest [s]."""
MAX_SETTLED_SPEED = 0.05
"""Largest speed of the centre of mass of a person who has settled [m/s]. Chosen."""
CONTACT_RATE = 25.0
"""Frames of a motion per second in which the bodies that touch the ground are looked for [1/s]."""
MAX_SETTLED_SHIFT = 0.05  # Largest displacement of the centre of mass while settling [m]. Chosen.


def surroundings(how: SimulateSettings) -> tuple[ModelMismatch, tuple[Disturbance, ...]]:
    """Return the model mismatch, its ground included, and the disturbances."""
    pushes: tuple[Disturbance, ...] = (
        *(Push.parse(word) for word in how.push),
        *(Rope.parse(word) for word in how.rope),
        *(ThrownBox.parse(word) for word in how.box),
        *((Load(how.load),) if how.load else ()),
        *(() if how.barrier is None else (Barrier.parse(how.barrier),)),
    )
    plate = None if how.ground is None else platform_named(how.ground)
    if how.shift is not None:
        shift = FloorShift.parse(how.shift)
        if how.ground not in (None, "flat"):
            raise ParameterError(f"shift needs a flat floor, not ground={how.ground!r}")
        acting: tuple[Disturbance, ...] = (shift, *pushes)
    else:
        acting = pushes if plate is None else (plate, *pushes)
    level = how.ground if len(acting) == len(pushes) else "flat"
    mismatch = ModelMismatch(
        mass=1.0 + 0.01 * how.mass_error_pct,
        friction=how.friction,
        ground=None if level is None else ground_named(level, seed=how.seed),
        delay=how.delay,
        sensors=float(np.deg2rad(how.sensor_noise_deg)),
        start=how.start_noise,
    )
    return mismatch, acting


def state_of(begin: Start, mismatch: ModelMismatch, how: SimulateSettings) -> tuple[Array, Array]:
    """Return the initial configuration and velocity.

    A person without a motion stands on the ground, with soles compressed by a second of standing,
    unless a held posture does not come to rest there.
    """
    if begin.motion is not None:
        return mismatch.initial_state(begin.human, begin.motion, begin.ground, how.seed)
    ground = mismatch.ground_of(begin.ground)
    stands = begin.standing(ground)
    world = World(
        begin.human,
        ground,
        rate=how.rate or RATE,
        control_rate=how.control_rate or CONTROL_RATE,
        recording=False,
        qpos=stands,
    )
    hold = Posture(stands, settings=settings_among(how.values, STANDING))
    state = world.reset()
    while world.time < SETTLING_TIME and world.fall is None and world.diverged is None:
        state = world.step(hold(state))
    first = BodyState(begin.human, stands).com
    moved, speed = state.body.com - first, state.body.com_velocity
    if (
        np.linalg.norm(moved) < MAX_SETTLED_SHIFT and np.linalg.norm(speed) < MAX_SETTLED_SPEED
    ):  # not where it diverged
        return np.array(state.qpos), mismatch.disturbed(state.qvel, how.seed)
    return stands, mismatch.disturbed(np.zeros(begin.human.model.nv), how.seed)


def world_of(
    begin: Start,
    mismatch: ModelMismatch,
    how: SimulateSettings,
    acting: Sequence[Disturbance],
    controller: Controller,
) -> World:
    """Return the world of a start, at the rates of its controller."""
    ground = mismatch.ground_of(begin.ground)
    wrenches = (
        () if begin.record is None else recorded_wrenches(begin.record, period_of(begin.record)[0])
    )
    world = world_for(
        controller,
        InitialState(begin.human, ground, *state_of(begin, mismatch, how)),
        (*wrenches, *acting),
        physics_rate=how.rate,
        control_rate=how.control_rate,
        torque_rise=how.torque_rise,
        torque_speed=how.torque_speed,
        sites=begin.sites,
        seed=how.seed,
    )
    mismatch.apply(world)
    if (motion := begin.motion) is not None:
        frames = spread(motion.n_frames, 1 + int(motion.duration * CONTACT_RATE))
        world.allow_contacts_of(motion.qpos[frames])
    return world
