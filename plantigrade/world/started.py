"""The world in which a person starts, as their controller needs it."""

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
    sites: Sequence[ContactSite] = (),
    seed: int = 0,
) -> World:
    """Return the world in which a person starts, at the rates of their controller.

    Args:
        controller: What moves the person.
        initial: How their motion begins; the controller may change it.
        disturbances: What else acts.
        physics_rate: Steps of the physics per second; the controller's if absent [1/s].
        control_rate: Commands and frames per second; the controller's if absent [1/s].
        recording: Whether frames are kept.
        torque_rise: As of :class:`World` [s].
        sites: Further places of the body by which seats carry it.
        seed: Seed of :attr:`World.random`.

    Raises:
        ParameterError: If the rates do not fit, or the state is none of this person.
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
        exact_limits=controller.exact_limits,
        qpos=initial.qpos,
        qvel=initial.qvel,
        sites=sites,
        seed=seed,
    )
