"""A world with the rates and the initial state that a controller needs."""

from collections.abc import Sequence

from plantigrade.contact.site import ContactSite
from plantigrade.world.controller import Controller, InitialState
from plantigrade.world.disturbance import Disturbance
from plantigrade.world.world import World


def world_for(
    controller: Controller,
    initial: InitialState,
    disturbances: Sequence[Disturbance] = (),
    *,
    physics_rate: float | None = None,
    control_rate: float | None = None,
    recording: bool = True,
    torque_rise: float = 0.0,
    torque_speed: bool = False,
    sites: Sequence[ContactSite] = (),
    seed: int = 0,
) -> World:
    """Return a world with the rates and the initial state of a controller.

    Args:
        initial: Initial state; the controller may change it.
        disturbances: Disturbances that act on the person.
        physics_rate: Steps of the physics per second; the controller's if absent [1/s].
        control_rate: Commands and frames per second; the controller's if absent [1/s].
        recording: Whether frames are kept.
        torque_rise: Rise time of torques, as in :class:`World` [s].
        torque_speed: Whether torques fall with the speed of their joints, likewise.
        seed: Seed of :attr:`World.random`.

    Raises:
        ParameterError: If the rates do not fit, or the state does not fit the person.
    """
    rates = controller.rates.changed(physics_rate, control_rate)
    initial = controller.start(initial)
    return World(
        initial.human,
        initial.ground,
        disturbances,
        rate=rates.physics,
        control_rate=rates.control,
        record_rate=rates.frames if recording else None,
        recording=recording,
        passive=controller.passive,
        torque_rise=torque_rise,
        torque_speed=torque_speed,
        exact_limits=controller.exact_limits,
        qpos=initial.qpos,
        qvel=initial.qvel,
        sites=sites,
        seed=seed,
    )
