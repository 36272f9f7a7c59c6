"""Walking with the learned policies of the package, one for each kind of foot: the measurements."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from experiments.cached_results import Cases, Result
from plantigrade.analyze.norms import norm, speed_class
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError
from plantigrade.learn import Policy, PolicyController
from plantigrade.learn.landing import PLATE_CUTOFF
from plantigrade.learn.policy import file_of, shipped
from plantigrade.motion.filters import lowpass
from plantigrade.options import is_policy
from plantigrade.record import Record
from plantigrade.world import Disturbance, InitialState, World, world_for
from plantigrade.world.grounds import ground_named
from plantigrade.world.standing import on_ground

FEET = ("multi-segment", "two-segment", "rigid")
RATE = 600.0
"""Rate of the physics [1/s]: four times that of the training."""
POINTS = 51
"""Number of points of a curve over the gait cycle."""
PRESSING_FORCE = 1.0
"""A contact point presses above this force [N]."""
MAX_OFF_LOAD = 0.01
"""Load below which a foot is off the ground [body weights]."""
MIN_ON_LOAD = 0.05
"""Load above which a foot is on the ground [body weights]."""
MIN_SWING = 0.1
"""Shortest time off the ground before a touchdown [s]."""
WARM_UP = 2.0
"""Duration at the beginning that is not measured [s]."""
REGIONS = {"heel": "heel", "midfoot": "_base_", "ball": "metatarsal_", "toes": "_toe_"}
"""Region of the sole → part of the names of its contact points; the first match counts."""
_RULES = ("form", "gains", "base", "reach", "rate", "control_rate", "passive", "mirrored")


@dataclass(frozen=True, kw_only=True)
class Walk:
    """Policy, ground and start of a learned walk.

    Attributes:
        foot: Kind of the feet, for the policy of the package; or a file of a policy.
        ground: Name of the ground.
        seed: Seed of the ground.
        begin: Phase of the stride at the start, from 0 to 1.
        held: Whether the stiffness of the feet is held at its middle, whatever the policy decides.
    """

    foot: str
    ground: str = "flat"
    seed: int = 0
    begin: float = 0.0
    held: bool = False

    def controller(self) -> PolicyController:
        """Return the controller of the policy."""
        policy = policy_of(self.foot)
        if not self.held:
            return PolicyController(policy, begin=self.begin)
        n = len(PolicyController(policy).joints)

        def middle(observation: Any) -> Any:
            decided = policy(observation).copy()
            decided[:, decided.shape[1] - n :] = 0.0
            return decided

        rules = {name: getattr(policy.rules, name) for name in _RULES}
        return PolicyController(middle, policy.reference, begin=self.begin, **rules)

    def world(
        self,
        controller: PolicyController,
        disturbances: tuple[Disturbance, ...] = (),
        *,
        recording: bool = False,
    ) -> World:
        """Return the world at the start of the walk."""
        start, ground = controller.record, ground_named(self.ground, seed=self.seed)
        qpos = start.motion.qpos[0]
        if self.ground != "flat":
            qpos = on_ground(start.human, ground, qpos)
        initial = InitialState(start.human, ground, qpos, start.motion.qvel[0])
        controller.rates = replace(controller.rates, physics=RATE)
        return world_for(controller, initial, disturbances, recording=recording)


def _upright(world: World) -> bool:
    return world.fall is None and world.diverged is None


def endure(walk: Walk, duration: float, disturbances: tuple[Disturbance, ...] = ()) -> Result:
    """Return time on the feet, RMS joint error and greatest lateral offset of a walk.

    Args:
        walk: The walk.
        duration: Longest duration [s].
        disturbances: The disturbances.
    """
    controller = walk.controller()
    world = walk.world(controller, disturbances)
    state, squares, lateral = world.reset(), [], 0.0
    while world.time < duration - 1e-9 and _upright(world):
        command = controller(state)
        squares.append(float(command.signals["tracking_error"]) ** 2)
        state = world.step(command)
        lateral = max(lateral, abs(float(state.qpos[1])))
    rms = float(np.rad2deg(np.sqrt(np.mean(squares))))
    return {"stood": _upright(world), "time": world.time, "off": rms, "beside": lateral}


def measure(walk: Walk, duration: float) -> Result:
    """Return errors, heel strikes, forces, stiffness and ankle moment of a walk over the cycle."""
    controller = walk.controller()
    world = walk.world(controller, recording=True)
    state, stiffness = world.reset(), []
    while world.time < duration - 1e-9 and _upright(world):
        command = controller(state)
        stiffness.append(command.signals.get("foot_stiffness", np.zeros(0)))
        state = world.step(command)
    record = world.record()
    found: Result = {"stood": _upright(world), "time": world.time}
    time, human = record.motion.time, record.human
    late = time > WARM_UP
    if late.sum() < 2 * POINTS:
        return found
    reference = controller.reference
    desired = reference.at(time + walk.begin * reference.period)
    error = np.rad2deg(record.motion.qpos[:, 7:] - desired.qpos[:, 7:])[late]
    within_feet = ("mtp", "cuboid", "heel")
    body = [i for i, c in enumerate(human.coordinates) if not c.startswith(within_feet)]
    found["body_rms"] = float(np.sqrt(np.mean(error[:, body] ** 2)))
    found["worst_rms"] = float(np.sqrt(np.mean(error[:, body] ** 2, axis=0)).max())
    ends = record.motion.qpos[late][[0, -1], 0]
    found["speed"] = float(np.diff(ends)[0] / np.ptp(time[late]))
    found["speed_wanted"] = reference.stride / reference.period
    force = np.asarray(record.contact_force)[..., 2]
    found["weight"] = float(force[late].sum(axis=1).mean() / record.weight)
    smooth = lowpass(time, force.sum(axis=1), cutoff=PLATE_CUTOFF)[late]
    found["peak_force"] = float(smooth.max() / record.weight)
    loads = {
        side: force[:, [i for i, site in enumerate(record.sites) if site.side == side]].sum(axis=1)
        / record.weight
        for side in SIDES
    }
    one = [lowpass(time, load, cutoff=PLATE_CUTOFF)[late].max() for load in loads.values()]
    found["foot_peak"] = float(max(one))
    found["double"] = float(
        np.mean((loads["r"] > MIN_ON_LOAD)[late] & (loads["l"] > MIN_ON_LOAD)[late])
    )
    found |= _landings(record, force)
    decided = np.arange(len(stiffness)) / controller.rates.control
    for side in SIDES:
        strikes = found["strikes"][side]
        for i, name in enumerate(controller.joints):
            if name.endswith(f"_{side}"):
                cycles = _cycles(decided, np.array(stiffness)[:, i], strikes)
                found.setdefault("stiffness", {}).setdefault(name[:-2], []).extend(cycles)
        found.setdefault("load", []).extend(_cycles(time, loads[side], strikes))
        moment = record.torque(f"ankle_angle_{side}") / human.mass
        found.setdefault("moment", []).extend(_cycles(time, moment, strikes))
    return found


def region(site: ContactSite) -> str:
    """Return the region of the sole that a contact point belongs to."""
    return next(name for name, part in REGIONS.items() if part in site.name)


def _landings(record: Record, force: Float[Array, "n_frames n_sites"]) -> Result:
    """Return touchdowns, share of heel strikes, contact onset of each region, stance time."""
    time, strikes, heel, onsets, stance = record.motion.time, {}, [], [], []
    for side in SIDES:
        mine = [i for i, site in enumerate(record.sites) if site.side == side]
        regions = np.array([region(record.sites[i]) for i in mine])
        load = force[:, mine].sum(axis=1) / record.weight
        off, landed, begun = 0.0, [], None
        for k in range(1, len(time)):
            if load[k] < MAX_OFF_LOAD:
                off += time[k] - time[k - 1]
                if begun is not None and off > 0.5 * MIN_SWING:
                    stance.append(time[k] - off - begun)
                    begun = None
            elif off >= MIN_SWING and load[k] > MIN_ON_LOAD:
                if time[k] > WARM_UP:
                    landed.append(float(time[k]))
                    first = k - int(np.argmin(force[k::-1, mine].max(axis=1) > PRESSING_FORCE)) + 1
                    pressing = regions[force[first, mine] > PRESSING_FORCE]
                    heel.append(bool(len(pressing)) and set(pressing) == {"heel"})
                    onsets.append(_onsets(force[first:, mine], time[first:], regions))
                    begun = float(time[k])
                off = 0.0
            elif load[k] > MIN_ON_LOAD:
                off = 0.0
        strikes[side] = landed
    begins = {r: [o[r] for o in onsets if r in o] for r in REGIONS}
    return {
        "strikes": strikes,
        "heel_first": float(np.mean(heel)) if heel else None,
        "begins": {r: float(np.median(t)) if t else None for r, t in begins.items()},
        "stance": float(np.median(stance)) if stance else None,
    }


def _onsets(force: Float[Array, "n k"], time: Float[Array, " n"], regions: Array) -> dict:
    """Return the time from touchdown to first pressure of each region in that stance [s]."""
    found: dict[str, float] = {}
    for k in range(len(time)):
        pressed = force[k] > PRESSING_FORCE
        if not pressed.any() and time[k] - time[0] > MIN_SWING:
            break
        for name in set(regions[pressed].tolist()):
            found.setdefault(name, float(time[k] - time[0]))
    return found


def _cycles(time: Array, values: Array, strikes: Sequence[float]) -> list[list[float]]:
    """Return a curve over each gait cycle, from heel strike to heel strike of the foot."""
    return [
        np.interp(np.linspace(start, stop, POINTS), time, values).tolist()
        for start, stop in zip(strikes[:-1], strikes[1:], strict=True)
        if 0.5 < stop - start < 2.0
    ]


def policy_of(foot: str) -> Policy:
    """Return the policy of the package for a kind of feet, or that of a file.

    Raises:
        ParameterError: If the package has none for such feet.
        FileError: If the file holds no policy.
    """
    return Policy.load(file_of(foot) if is_policy(foot) else shipped(foot))


def ankle_norm(foot: str, speed: float) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
    """Return mean and standard deviation of children's ankle moment at a speed [N m/kg].

    From [Schwartz2008]_, at :data:`POINTS` instants of the cycle, for the leg length of the
    policy's person.
    """
    d = policy_of(foot).reference.human.dimensions
    kind = speed_class(speed, d.thigh + d.shank + d.ankle_height)
    curve = norm("ankle_angle_moment", kind)
    at = np.linspace(0.0, 100.0, POINTS)
    return np.interp(at, curve.percent, curve.mean), np.interp(at, curve.percent, curve.sd)


def moment_agreement(own: Float[Array, " points"], mean: Float[Array, " points"]) -> Result:
    """Return correlation, ratio of peaks and RMS difference [N m/kg] of two ankle moments."""
    return {
        "r": float(np.corrcoef(own, mean)[0, 1]),
        "ratio": float(own.min() / mean.min()),
        "apart": float(np.sqrt(np.mean((own - mean) ** 2))),
    }


@cache
def available_feet() -> tuple[str, ...]:
    """Return the kinds of feet for which the package has a policy."""

    def available(foot: str) -> bool:
        try:
            return bool(shipped(foot))
        except ParameterError:
            return False

    return tuple(filter(available, FEET))


def training_value(foot: str, name: str) -> float:
    """Return a number of how the policy for such feet was trained; zero if absent.

    Args:
        foot: The kind of feet.
        name: Its name in the file, such as ``"terrain_m"``.
    """
    return float(Policy.load(shipped(foot)).about.get(name, 0.0))


def cases_of(part: str, make: Callable[[str], Mapping[str, Callable[[], Result]]]) -> Cases:
    """Return the cases of a part for all available feet, with keys ``part/foot`` or longer."""
    return {
        "/".join(filter(None, (part, foot, name))): case
        for foot in available_feet()
        for name, case in make(foot).items()
    }


def summary(result: Result) -> str:
    """Return one line about a walk."""
    return f"{'walked' if result['stood'] else 'fell after'} {result['time']:.1f} s"
