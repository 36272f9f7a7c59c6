"""Impairments in words: ranges, strengths, braces and soles of a person who does a task.

The words are those of the command line and of the table ``[impairments]`` of a task file. Nothing
here loads NumPy before a person is impaired.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from typing import TYPE_CHECKING, Annotated

import tyro

from plantigrade.bounds import Bounded, number, shown
from plantigrade.constants import MAX_LOAD, SIDES
from plantigrade.errors import CoordinateNotFound, ParameterError, known_names
from plantigrade.options import optional
from plantigrade.side_names import split_side

if TYPE_CHECKING:
    from plantigrade.models.human import Human
    from plantigrade.trajopt.tasks.task import MotionTask
    from plantigrade.trajopt.terms.term import Term

MAX_ANGLE = 360.0
"""Largest angle of a range or a brace [deg]: a full turn."""
MAX_STRENGTH = 3.0  # Largest strength, as part of the person's own [1]; chosen
MAX_STIFFNESS = 50.0
"""Largest stiffness of a brace [N m/deg]; rigid ankle-foot orthoses have about 7."""
MAX_SOLE = 0.05  # Largest change of a sole [m], half of what a contact sphere may be moved by
MAX_TORQUE = 300.0  # [N m] largest torque of a device; strong people push off with 200
MAX_PULL = 999.0  # [N] largest component of a force on a body; more than a body weight
LOAD_PAIRS = {"hands": "hand", "thighs": "thigh", "shanks": "shank", "feet": "foot"}
"""Name of a pair of places of a load, half in each → their name, without side."""
LOAD_PLACES = (
    "back", "waist", *LOAD_PAIRS, *(f"{x}_{s}" for x in LOAD_PAIRS.values() for s in SIDES),
)  # fmt: skip

Words = tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Impairments(Bounded):
    """Limits of a person, each as NAME=VALUE, in degrees.

    A name is that of a coordinate (``knee_angle_r``), or its beginning (``knee_r``, ``hip`` for all
    of both hips).
    """

    limit: Annotated[Words, tyro.conf.UseAppendAction, optional("NAME=LOW:HIGH")] = ()
    """Range of a joint [deg], such as knee_r=0:20; repeatable."""
    joint_strength: Annotated[Words, tyro.conf.UseAppendAction, optional("NAME=PART[:PART]")] = ()
    """Part of the strength of a joint, such as ankle_r=0.5; of its negative and positive direction
    with a colon; repeatable; --strength NAME=PART is the same."""
    brace: Annotated[Words, tyro.conf.UseAppendAction, optional("NAME=NM/DEG[@DEG]")] = ()
    """Spring across a joint: stiffness [N m/deg] and neutral angle, such as ankle_r=3@0;
    repeatable."""
    sole: Annotated[Words, tyro.conf.UseAppendAction, optional("SIDE=METRES")] = ()
    """Thicker sole of a foot (r or l), which lengthens its leg [m], such as r=0.02; repeatable."""

    load: Annotated[Words, tyro.conf.UseAppendAction, optional("PLACE=KG")] = ()
    """Load on back, waist, hands, thighs, shanks or feet, half on each side, or on one side
    (hand_r) [kg], such as back=20; repeatable."""

    wrench: Annotated[Words, tyro.conf.UseAppendAction, optional("BODY=FX,FY,FZ")] = ()
    """Force at the middle of a body, forward, to the left and up [N], such as pelvis=-50,0,0, or
    trunk, hand_r, hand_l; repeatable."""

    device: Annotated[
        Words, tyro.conf.UseAppendAction, optional("NAME=torque:NM|spring:NM/DEG")
    ] = ()
    """Device at a joint of both legs or of one, in periodic walks and runs: torque at its peak
    [N m] and times of peak, rise and fall [% of the stride], such as ankle=torque:-40@53,26,10
    (negative: plantarflexion); or a spring that a clutch couples while the foot stands, with
    stiffness [N m/deg] and the angle beyond which it pulls, such as ankle=spring:3@0;
    repeatable."""

    def __post_init__(self):
        super().__post_init__()
        for word in self.limit:
            self._range(word)
        for word in self.joint_strength:
            self._parts(word)
        for word in self.brace:
            self._spring(word)
        for word in self.sole:
            self._sole(word)
        self._loads()
        for word in self.wrench:
            self._pull(word)
        for word in self.device:
            self._device(word)

    @property
    def words(self) -> list[str]:
        """Every impairment in words."""
        return [
            *(f"{n} from {lo:g} to {hi:g}°" for n, (lo, hi) in map(self._range, self.limit)),
            *(f"strength {word.replace('=', ' ')}" for word in self.joint_strength),
            *(f"brace {n} {k:g} N m/° at {at:g}°" for n, k, at in map(self._spring, self.brace)),
            *(f"sole {s} {1e3 * up:+g} mm" for s, up in map(self._sole, self.sole)),
            *(f"load {word.replace('=', ' ')} kg" for word in self.load),
            *(f"force {word.replace('=', ' ')} N" for word in self.wrench),
            *(f"device {word.replace('=', ' ')}" for word in self.device),
        ]

    def person(self, human: "Human") -> "Human":
        """Return the person with these soles and loads."""
        if self.load:
            human = human.with_loads(self._loads())
        thicker = dict(map(self._sole, self.sole))
        offsets = {n: -thicker[s] for n, s, _ in human.contact_points if thicker.get(s)}
        return human.with_soles(offsets) if offsets else human

    def task(self, human: "Human", task: "MotionTask") -> "MotionTask":
        """Return the task with the terms of these impairments.

        Raises:
            CoordinateNotFound: If the person has no such coordinate.
            ParameterError: If a name means several coordinates where one is needed.
        """
        return task.with_terms(*self._terms(human))

    def _terms(self, human: "Human") -> "list[Term]":
        from plantigrade.contact.site import Point
        from plantigrade.trajopt.terms.device import Device
        from plantigrade.trajopt.terms.external import Wrench
        from plantigrade.trajopt.terms.impairment import Brace, Uneven, Weakness
        from plantigrade.trajopt.terms.limits import Within

        found: list[Term] = []
        for name, (low, high) in map(self._range, self.limit):
            for each in _coordinates(human, name, one=True):
                found.append(Within(each, radians(low), radians(high)))
        for name, (negative, positive) in map(self._parts, self.joint_strength):
            found += [Weakness(each, negative, positive) for each in _coordinates(human, name)]
        for name, stiffness, neutral in map(self._spring, self.brace):
            per_radian = stiffness / radians(1.0)
            for each in _coordinates(human, name, one=True):
                found.append(Brace(each, per_radian, radians(neutral)))
        sides = dict(map(self._sole, self.sole))
        if sides.get("r", 0.0) != sides.get("l", 0.0):
            found += [Uneven(side) for side in sides]
        loads = self._loads()
        if any(loads.get(f"{x}_r", 0.0) != loads.get(f"{x}_l", 0.0) for x in LOAD_PAIRS.values()):
            found.append(Uneven("r"))
        for name, force in map(self._pull, self.wrench):
            body = human.trunk if name == "trunk" else name
            middle = human.model.body_ipos[human.body(body)]
            found.append(Wrench(Point(body, middle), force))
        for name, given in map(self._device, self.device):
            found += [Device(each, **given) for each in _coordinates(human, name, one=True)]
        return found

    def _device(self, word: str) -> tuple[str, dict[str, float]]:
        name, value = _split("device", word, "ankle=torque:-40 or ankle=spring:3@0")
        kind, _, rest = value.partition(":")
        size, _, more = rest.partition("@")
        if kind == "spring":
            (stiff,) = _numbers("device", word, [size], 1, 0.0, MAX_STIFFNESS, "N m/deg")
            (taut,) = _numbers("device", word, [more or "0"], 1, -MAX_ANGLE, MAX_ANGLE, "degrees")
            return name, {"stiffness": stiff / radians(1.0), "taut": radians(taut)}
        if kind == "torque":
            (peak,) = _numbers("device", word, [size], 1, -MAX_TORQUE, MAX_TORQUE, "N m")
            times = (
                _numbers("device", word, more.split(","), 3, 1.0, 99.0, "%", ",") if more else []
            )
            shares = (x / 100.0 for x in times)
            return name, {
                "torque": peak,
                **dict(zip(("peak", "rise", "fall"), shares, strict=False)),
            }
        raise ParameterError(
            f"device={shown(word)}: write {name}=torque:NM or {name}=spring:NM/DEG"
        )

    def _pull(self, word: str) -> tuple[str, tuple[float, float, float]]:
        name, value = _split("wrench", word, "BODY=FX,FY,FZ, such as pelvis=-50,0,0")
        x, y, z = _numbers("wrench", word, value.split(","), 3, -MAX_PULL, MAX_PULL, "N", ",")
        return name, (x, y, z)

    def _loads(self) -> dict[str, float]:
        """Return the mass at each place [kg]."""
        found: dict[str, float] = {}
        for word in self.load:
            name, value = _split("load", word, "PLACE=KG, such as back=20")
            if name not in LOAD_PLACES:
                raise ParameterError(f"load={shown(word)}: {known_names(name, LOAD_PLACES)}")
            pair = LOAD_PAIRS.get(name)
            places = (name,) if pair is None else tuple(f"{pair}_{side}" for side in SIDES)
            (mass,) = _numbers("load", word, [value], 1, 0.0, MAX_LOAD, "kg")
            for place in places:
                found[place] = found.get(place, 0.0) + mass / len(places)
        return found

    def _range(self, word: str) -> tuple[str, tuple[float, float]]:
        name, value = _split("limit", word, "NAME=LOW:HIGH, such as knee_r=0:20")
        low, high = _numbers("limit", word, value.split(":"), 2, -MAX_ANGLE, MAX_ANGLE, "degrees")
        if not low < high:
            raise ParameterError(f"limit={shown(word)}: the first angle must be the smaller one")
        return name, (low, high)

    def _parts(self, word: str) -> tuple[str, tuple[float, float]]:
        name, value = _split("joint_strength", word, "NAME=PART, such as ankle_r=0.5")
        parts = value.split(":")
        parts = parts * 2 if len(parts) == 1 else parts
        low, high = _numbers("joint_strength", word, parts, 2, 0.0, MAX_STRENGTH, "")
        return name, (low, high)

    def _spring(self, word: str) -> tuple[str, float, float]:
        name, value = _split("brace", word, "NAME=NM/DEG or NAME=NM/DEG@DEG, such as ankle_r=3@0")
        stiff, _, neutral = value.partition("@")
        (stiffness,) = _numbers("brace", word, [stiff], 1, 0.0, MAX_STIFFNESS, "N m/deg")
        (angle,) = _numbers("brace", word, [neutral or "0"], 1, -MAX_ANGLE, MAX_ANGLE, "degrees")
        return name, stiffness, angle

    def _sole(self, word: str) -> tuple[str, float]:
        side, value = _split("sole", word, "r=METRES or l=METRES, such as r=0.02")
        if side not in ("r", "l"):
            raise ParameterError(f"sole={shown(word)}: the side is r or l")
        (thicker,) = _numbers("sole", word, [value], 1, -MAX_SOLE, MAX_SOLE, "m")
        if thicker < 0.0:  # the ball would be above the axis of the toes and press into the ground
            name, other = ("right", "l") if side == "r" else ("left", "r")
            raise ParameterError(
                f"sole={shown(word)}: a bare foot has no sole to take away; for a {name} leg that "
                f"is {-1e3 * thicker:g} mm shorter, thicken the other sole: {other}={-thicker:g}"
            )
        return side, thicker


def _split(option: str, word: str, form: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise ParameterError(f"{option}={shown(word)}: write {form}")
    return name.strip(), value.strip()


def _numbers(
    option: str,
    word: str,
    words: Sequence[str],
    n: int,
    low: float,
    high: float,
    unit: str,
    mark: str = ":",
) -> list[float]:
    try:
        values = [float(each) for each in words]
    except ValueError:
        values = []
    if len(values) != n:
        needed = "a number is" if n == 1 else f"{n} numbers with {mark!r} between are"
        raise ParameterError(f"{option}={shown(word)}: {needed} needed")
    for value in values:
        number(f"{option} {word.partition('=')[0]}", value, low, high, unit, "an impairment")
    return values


def _coordinates(human: "Human", name: str, *, one: bool = False) -> list[str]:
    """Return the coordinates of a name: its own, with both sides, or all that begin with it."""
    stem, side = split_side(name)
    of_side = [c for c in human.coordinates if not side or c.endswith(f"_{side}")]
    exact = [c for c in of_side if c == name or c[:-2] == stem]
    found = exact or [c for c in of_side if c.startswith(f"{stem}_")]
    if not found:
        raise CoordinateNotFound(
            f"no coordinate {shown(name)} in joint set {human.joints}; "
            f"{known_names(name, human.coordinates)}"
        )
    if one and len({c[:-2] for c in found}) > 1:
        raise ParameterError(f"{name} is several coordinates, name one: {', '.join(found)}")
    return found
