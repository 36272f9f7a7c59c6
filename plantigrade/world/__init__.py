"""The physics simulation: a person on a ground, with disturbances, stepped by any controller.

The names of this package are public: a :class:`World` with a ``controller(state) -> command``::

    world = World(Human.create(), disturbances=(Push(force=100.0, duration=0.2, time=1.0),))
    record = world.simulate(lambda state: StablePD(state.human.standing()[7:]), 3.0)
"""

from plantigrade.world.barrier import Barrier
from plantigrade.world.box import Box, ThrownBox
from plantigrade.world.command import PD, Acceleration, Command, StablePD, Torque
from plantigrade.world.controller import (
    AnyController,
    Controller,
    Drawing,
    InitialState,
    Rates,
    Summary,
    Target,
    WrappedController,
    controller_from,
)
from plantigrade.world.disturbance import Disturbance, PhasePush, Push
from plantigrade.world.falls import Fall
from plantigrade.world.load import Load
from plantigrade.world.platform import FloorShift, Platform, Tilting
from plantigrade.world.rope import Rope
from plantigrade.world.simulated_world import SimulatedWorld
from plantigrade.world.standing import fit_soles, on_ground, standing_on
from plantigrade.world.state import State
from plantigrade.world.world import World
from plantigrade.world.world_for import world_for

__all__ = [
    "Barrier",
    "PD",
    "Acceleration",
    "AnyController",
    "Box",
    "Command",
    "Controller",
    "Disturbance",
    "Drawing",
    "Fall",
    "FloorShift",
    "InitialState",
    "Load",
    "PhasePush",
    "Platform",
    "Push",
    "Rates",
    "Rope",
    "SimulatedWorld",
    "StablePD",
    "State",
    "Summary",
    "ThrownBox",
    "Target",
    "Tilting",
    "Torque",
    "World",
    "WrappedController",
    "controller_from",
    "fit_soles",
    "on_ground",
    "standing_on",
    "world_for",
]
