"""Scripts of foot motions: where the ankles are, which segments press the ground, and when.

A script is a TOML file that anyone can edit (those of :data:`MOTIONS` are in ``motions/``)::

    title = "On tiptoe"

    [[frame]]
    time = 1.5
    both = { presses = ["medial_phalanges", "lateral_phalanges"], ankle = [0.0, 0.0, 0.04] }
    [[frame]]
    time = 6.0

Every frame says where the feet are at a time: ``right``, ``left`` or ``both``, with ``ankle``, how
far the ankle is from where it is in standing, forward, to the left and up, in metres of a person of
1.74 m; and ``presses``, the segments on the ground (names of
:data:`~plantigrade.kinematics.foot_pose.MARKS`), ``[]`` for a foot in the air. What a frame does
not say stays as it was; before the first one the person stands. ``body`` moves the centre of mass
likewise, from where it would be by itself. ``toward`` says where within what presses of a foot the
pressure is to be, forward and to the left, from -1 to 1: ``[0, 1]`` for its left border. A foot
that was not told presses as evenly as it can. On the way from one frame to the next those segments
press that do at both ends. Between frames where no foot does the body flies for just so long
(:mod:`plantigrade.control.balance.paths`): the one before it is the take-off, the one after it the
landing, and those beside them are how deep it crouches. A script that asks for more force than
people have is refused; one whose flight or landing comes sooner or later than written is followed
from when it does (:mod:`plantigrade.control.balance.flight`).

The feet are posed by the paper's controller (:mod:`plantigrade.kinematics.foot_pose`), and the body
above them by least squares: joints as in standing, the centre of mass over what presses now and
next, and as little angular momentum as that allows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError
from plantigrade.kinematics.foot_pose import MARKS, SEGMENTS, marks
from plantigrade.toml import parse_toml, read_toml

MOTIONS = ("tiptoe", "tilt-inside", "tilt-outside", "circling", "one-foot", "jump")
"""Scripts that come with the package."""
SHORTEST, LONGEST = 0.1, 600.0
"""Shortest and longest script [s]."""
FARTHEST = 0.5
"""Farthest an ankle or the body may be from where it stands [m]."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Where the feet are to be at a time.

    Attributes:
        time: When [s].
        ankle: How far each ankle, right first, is from where it is in standing [m].
        presses: Which of :data:`~plantigrade.kinematics.foot_pose.MARKS` press, for each foot.
        body: How far the centre of mass is from where it would be by itself [m].
        toward: Where within what presses each foot presses most, forward and to the left, from -1
            to 1; NaN where that is left open.
    """

    time: float
    ankle: Float[Array, "2 3"]
    presses: Bool[Array, "2 n_marks"]
    body: Float[Array, " 3"]
    toward: Float[Array, "2 2"]


@dataclass(frozen=True, eq=False)
class Script:
    """A script.

    Attributes:
        title: What it is called.
        frames: Its frames, the first at time zero: standing.
    """

    title: str
    frames: tuple[Frame, ...]

    @property
    def duration(self) -> float:
        """When it ends [s]."""
        return self.frames[-1].time


def script_named(word: str) -> Script:
    """Return one of :data:`MOTIONS`, or the script in a TOML file.

    Raises:
        ParameterError: If there is no such script, or it is no script.
    """
    if word in MOTIONS:
        text = files("plantigrade.control.balance").joinpath("motions", f"{word}.toml")
        return _read(Path(str(text)), word)
    if not word.endswith(".toml"):
        raise ParameterError(f"no motion {word!r}; there are {', '.join(MOTIONS)}, or a TOML file")
    return _read(Path(word), word)


def _read(path: Path, name: str) -> Script:
    return _script(parse_toml(read_toml(path), path), name)


def _script(told: Mapping[str, Any], name: str) -> Script:
    if unknown := set(told) - {"title", "frame"}:
        raise ParameterError(
            f"{name} says {', '.join(sorted(unknown))}; it may say title and frame"
        )
    rows = told.get("frame")
    if not isinstance(rows, list) or not rows:
        raise ParameterError(f"{name} has no [[frame]]")
    flat = np.tile(marks(*SEGMENTS), (2, 1))
    frames = [Frame(0.0, np.zeros((2, 3)), flat, np.zeros(3), np.full((2, 2), np.nan))]
    for i, row in enumerate(rows):
        where = f"{name}, frame {i + 1}"
        if not isinstance(row, Mapping):
            raise ParameterError(f"{where} is no table")
        frames.append(_frame(row, frames[-1], where))
    if frames[-1].time < SHORTEST:
        raise ParameterError(
            f"{name} ends at {frames[-1].time:g} s; a script lasts {SHORTEST:g} s at least"
        )
    return Script(str(told.get("title", name)), tuple(frames))


def _frame(row: Mapping[str, Any], before: Frame, where: str) -> Frame:
    """Return a frame, what it does not say as in the one before."""
    if unknown := set(row) - {"time", "right", "left", "both", "body"}:
        raise ParameterError(f"{where} says {', '.join(sorted(unknown))}")
    time = row.get("time")
    if time is None or not _is_number(time) or not before.time < time <= LONGEST:
        raise ParameterError(
            f"{where}: time={time!r} must be after {before.time:g} s and at most {LONGEST:g} s"
        )
    ankle, presses, toward = before.ankle.copy(), before.presses.copy(), before.toward.copy()
    for word, feet in (("both", (0, 1)), ("right", (0,)), ("left", (1,))):
        told = row.get(word, {})
        if not isinstance(told, Mapping) or set(told) - {"ankle", "presses", "toward"}:
            raise ParameterError(f"{where}: {word} may say ankle, presses and toward")
        for foot in feet:
            if "ankle" in told:
                ankle[foot] = _numbers(told["ankle"], 3, FARTHEST, f"{where}: ankle [m]")
            if "toward" in told:
                toward[foot] = _numbers(told["toward"], 2, 1.0, f"{where}: toward")
            if "presses" in told:
                names = told["presses"]
                if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
                    raise ParameterError(f"{where}: presses is a list of {', '.join(MARKS)}")
                if wrong := set(names) - set(MARKS):
                    raise ParameterError(
                        f"{where}: no segment {', '.join(sorted(wrong))}; there are "
                        f"{', '.join(MARKS)}"
                    )
                presses[foot] = marks(*names)
    body = before.body
    if "body" in row:
        body = _numbers(row["body"], 3, FARTHEST, f"{where}: body [m]")
    return Frame(float(time), ankle, presses, body, toward)


def _is_number(told: Any) -> bool:
    return isinstance(told, int | float) and not isinstance(told, bool)


def _numbers(told: Any, n: int, most: float, where: str) -> Array:
    numbers = isinstance(told, list) and all(_is_number(x) for x in told)
    if not numbers or len(told) != n or not np.abs(told).max() <= most:
        count = {2: "two", 3: "three"}[n]
        raise ParameterError(f"{where} is {count} numbers, none beyond {most:g}, not {told!r}")
    return np.array(told, dtype=float)
