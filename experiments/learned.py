"""Walking with the learned policies of the package, one for each kind of foot: what is measured."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.analyze.norms import norm, speed_class
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError
from plantigrade.learn import Policy, PolicyController
from plantigrade.motion.filters import lowpass
from plantigrade.record import Record
from plantigrade.workflows.policies import file_of, is_policy, shipped
from plantigrade.world import Disturbance, InitialState, World, world_for
from plantigrade.world.grounds import ground_named
from plantigrade.world.standing import on_ground

FEET = ("multi-segment", "two-segment", "rigid")
RATE = 600.0
"""Of the physics [1/s]: four times that of the training."""
POINTS = 51
"""Of a curve over the gait cycle."""
PRESSED, OFF, LOADED = 1.0, 0.01, 0.05
"""A place presses with more [N]; a foot is off the ground below, on it above [body weights]."""
SWING = 0.1
"""A foot that strikes was off the ground for so long [s]."""
PLATE = 20.0
"""Low-pass of forces, as of recorded plates [Hz]."""
WARM = 2.0
"""What happens before is not measured [s]."""
REGIONS = {"heel": "heel", "midfoot": "_base_", "ball": "metatarsal_", "toes": "_toe_"}
"""Region of the sole → what names of its places have; the first that fits."""


@dataclass(frozen=True, kw_only=True)
class Walk:
    """Who walks, and on what.

    Attributes:
        foot: Kind of the feet, for the policy of the package; or a file of a policy.
        ground: What they walk on, by name.
        seed: Of the ground.
        begin: At which part of the stride they begin, from 0 to 1.
        held: Whether the stiffness of the feet is held at its middle, whatever the policy decides.
    """

    foot: str
    ground: str = "flat"
    seed: int = 0
    begin: float = 0.0
    held: bool = False

    def controller(self) -> PolicyController:
        """Return the policy that moves them."""
        policy = policy_of(self.foot)
        if not self.held:
            return PolicyController(policy, begin=self.begin)
        n = len(PolicyController(policy).joints)

        def soft(seen: Any) -> Any:
            decided = policy(seen).copy()
            decided[:, decided.shape[1] - n :] = 0.0
            return decided

        rules = {name: getattr(policy.rules, name) for name in _RULES}
        return PolicyController(soft, policy.reference, begin=self.begin, **rules)

    def world(
        self,
        controller: PolicyController,
        acting: tuple[Disturbance, ...] = (),
        *,
        recording: bool = False,
    ) -> World:
        """Return the world in which they begin."""
        start, ground = controller.record, ground_named(self.ground, seed=self.seed)
        qpos = start.motion.qpos[0]
        if self.ground != "flat":
            qpos = on_ground(start.human, ground, qpos)
        initial = InitialState(start.human, ground, qpos, start.motion.qvel[0])
        controller.rates = replace(controller.rates, physics=RATE)
        return world_for(controller, initial, acting, recording=recording)


_RULES = ("form", "gains", "base", "reach", "rate", "control_rate", "passive", "mirrored")


def last(walk: Walk, duration: float, acting: tuple[Disturbance, ...] = ()) -> dict[str, Any]:
    """Return for how long somebody walks.

    Args:
        walk: Who, on what.
        duration: At most so long [s].
        acting: What else acts.
    """
    controller = walk.controller()
    world = walk.world(controller, acting)
    state, squares, away = world.reset(), [], 0.0
    while world.time < duration - 1e-9 and world.fall is None and world.diverged is None:
        command = controller(state)
        squares.append(float(command.signals["tracking_error"]) ** 2)
        state = world.step(command)
        away = max(away, abs(float(state.qpos[1])))
    stood = world.fall is None and world.diverged is None
    rms = float(np.rad2deg(np.sqrt(np.mean(squares))))
    return {"stood": stood, "time": world.time, "off": rms, "beside": away}


def measure(walk: Walk, duration: float) -> dict[str, Any]:
    """Return what a walk is like: errors, strikes, forces, stiffness and ankle over the cycle."""
    controller = walk.controller()
    world = walk.world(controller, recording=True)
    state, stiffness = world.reset(), []
    while world.time < duration - 1e-9 and world.fall is None and world.diverged is None:
        command = controller(state)
        stiffness.append(command.signals.get("foot_stiffness", np.zeros(0)))
        state = world.step(command)
    record = world.record()
    found: dict[str, Any] = {"stood": world.fall is None and world.diverged is None}
    found["time"] = world.time
    time, human = record.motion.time, record.human
    late = time > WARM
    if late.sum() < 2 * POINTS:
        return found
    wanted = controller.reference.at(time + walk.begin * controller.reference.period)
    off = np.rad2deg(record.motion.qpos[:, 7:] - wanted.qpos[:, 7:])[late]
    outside = [i for i, c in enumerate(human.coordinates) if not _inner(c)]
    found["body_rms"] = float(np.sqrt(np.mean(off[:, outside] ** 2)))
    found["worst_rms"] = float(np.sqrt(np.mean(off[:, outside] ** 2, axis=0)).max())
    gone = record.motion.qpos[late][[0, -1], 0]
    found["speed"] = float(np.diff(gone)[0] / np.ptp(time[late]))
    found["speed_wanted"] = controller.reference.stride / controller.reference.period
    force = np.asarray(record.contact_force)[..., 2]
    found["weight"] = float(force[late].sum(axis=1).mean() / record.weight)
    smooth = lowpass(time, force.sum(axis=1), cutoff=PLATE)[late]
    found["peak_force"] = float(smooth.max() / record.weight)
    found |= _feet(record, force)
    decided = np.arange(len(stiffness)) / controller.rates.control
    table = np.array(stiffness)
    for side in SIDES:
        mine = [i for i, name in enumerate(controller.joints) if name.endswith(f"_{side}")]
        for i in mine:
            name = controller.joints[i][:-2]
            cycles = _over(decided, table[:, i], found["strikes"][side])
            found.setdefault("stiffness", {}).setdefault(name, []).extend(cycles)
        own = [i for i, site in enumerate(record.sites) if site.side == side]
        load = force[:, own].sum(axis=1) / record.weight
        found.setdefault("load", []).extend(_over(time, load, found["strikes"][side]))
        moment = record.torque(f"ankle_angle_{side}") / human.mass
        found.setdefault("moment", []).extend(_over(time, moment, found["strikes"][side]))
    return found


def _inner(coordinate: str) -> bool:
    """Return whether a coordinate is one within a foot."""
    return coordinate.startswith(("mtp", "cuboid", "heel"))


def region(site: ContactSite) -> str:
    """Return the region of the sole that a place belongs to."""
    return next(name for name, word in REGIONS.items() if word in site.name)


def _feet(record: Record, force: Float[Array, "n_frames n_sites"]) -> dict[str, Any]:
    """Return when feet strike, with what first, and when each region begins to press."""
    time, strikes, heel, order, stance = record.motion.time, {}, [], [], []
    for side in SIDES:
        mine = [i for i, site in enumerate(record.sites) if site.side == side]
        where = np.array([region(record.sites[i]) for i in mine])
        load = force[:, mine].sum(axis=1) / record.weight
        off, landed, begun = 0.0, [], None
        for k in range(1, len(time)):
            if load[k] < OFF:
                off += time[k] - time[k - 1]
                if begun is not None and off > 0.5 * SWING:
                    stance.append(time[k] - off - begun)
                    begun = None
            elif off >= SWING and load[k] > LOADED:
                if time[k] > WARM:
                    landed.append(float(time[k]))
                    first = k - int(np.argmin(force[k::-1, mine].max(axis=1) > PRESSED)) + 1
                    pressing = where[force[first, mine] > PRESSED]
                    heel.append(bool(len(pressing)) and set(pressing) == {"heel"})
                    order.append(_pressing(force[first:, mine], time[first:], where))
                    begun = float(time[k])
                off = 0.0
            elif load[k] > LOADED:
                off = 0.0
        strikes[side] = landed
    begins = {r: [o[r] for o in order if o[r] is not None] for r in REGIONS}
    return {
        "strikes": strikes,
        "heel_first": float(np.mean(heel)) if heel else None,
        "begins": {r: float(np.median(t)) if t else None for r, t in begins.items()},
        "stance": float(np.median(stance)) if stance else None,
    }


def _pressing(
    force: Float[Array, "n k"], time: Float[Array, " n"], where: Array
) -> dict[str, float | None]:
    """Return how long after the strike each region begins to press, within that stance [s]."""
    found: dict[str, float | None] = dict.fromkeys(REGIONS)
    for k in range(len(time)):
        pressed = force[k] > PRESSED
        if not pressed.any() and time[k] - time[0] > SWING:
            break
        for name in set(where[pressed].tolist()):
            if found[name] is None:
                found[name] = float(time[k] - time[0])
    return found


def _over(time: Array, values: Array, strikes: list[float]) -> list[list[float]]:
    """Return a curve over each gait cycle, from strike to strike of the foot."""
    cycles = []
    for start, stop in zip(strikes[:-1], strikes[1:], strict=True):
        if 0.5 < stop - start < 2.0:
            at = np.linspace(start, stop, POINTS)
            cycles.append(np.interp(at, time, values).tolist())
    return cycles


def policy_of(foot: str) -> Policy:
    """Return the policy of the package for a kind of feet, or that of a file.

    Raises:
        ParameterError: If the package has none for such feet.
        FileError: If the file holds no policy.
    """
    return Policy.load(file_of(foot) if is_policy(foot) else shipped(foot))


def ankle_norm(foot: str, speed: float) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
    """Return mean and standard deviation of children's ankle moment at a speed [N m/kg].

    Of [Schwartz2008]_, at :data:`POINTS` instants of the cycle, for the leg of the policy's person.
    """
    d = policy_of(foot).reference.human.dimensions
    kind = speed_class(speed, d.thigh + d.shank + d.ankle_height)
    curve = norm("ankle_angle_moment", kind)
    at = np.linspace(0.0, 100.0, POINTS)
    return np.interp(at, curve.percent, curve.mean), np.interp(at, curve.percent, curve.sd)


def likened(own: Float[Array, " points"], mean: Float[Array, " points"]) -> dict[str, float]:
    """Return how like a measured moment one is: r, peak by peak, and distance [N m/kg]."""
    return {
        "r": float(np.corrcoef(own, mean)[0, 1]),
        "ratio": float(own.min() / mean.min()),
        "apart": float(np.sqrt(np.mean((own - mean) ** 2))),
    }


def there() -> Iterator[str]:
    """Yield the kinds of feet for which the package has a policy."""
    for foot in FEET:
        try:
            shipped(foot)
        except ParameterError:
            continue
        yield foot


def learned_with(foot: str, what: str) -> float:
    """Return a number of how the policy of the package for such feet was trained; zero if absent.

    Args:
        foot: The kind of feet.
        what: Its name in the file, such as ``"terrain_m"``.
    """
    return float(Policy.load(shipped(foot)).about.get(what, 0.0))


def in_words(result: dict[str, Any]) -> str:
    """Return one result in a line."""
    return f"{'walked' if result['stood'] else 'fell after'} {result['time']:.1f} s"
