"""Scripts of foot motions: where the ankles are, which segments press the ground, and when.

A script is a TOML file that anyone can edit (those of :data:`MOTIONS` are in ``motions/``)::

    title = "On tiptoe"

    [[frame]]
    time = 1.5
    both = { presses = ["medial_phalanges", "lateral_phalanges"], ankle = [0.0, 0.0, 0.04] }
    [[frame]]
    time = 6.0

A frame has the feet at a time: ``right``, ``left`` or ``both``, with ``ankle``, the offset of the
ankle from standing, forward, to the left and up, in metres of a person of 1.74 m; and ``presses``,
the segments on the ground (names of :data:`~plantigrade.kinematics.foot_pose.MARKS`), ``[]`` for a
foot in the air. Values that a frame does not mention stay as they were; before the first one the
person stands. ``body`` offsets the centre of mass likewise. ``toward`` is
the desired pressure within what presses of a foot, forward and to the left, from -1 to 1:
``[0, 1]`` for its left border; a foot without it presses as evenly as it can. From one frame to the
next those segments press that do at both ends. Between frames where no foot does the body flies for
just as long (:mod:`plantigrade.control.balance.script_motion`): the frame before is the take-off,
the one after it the touchdown, and their neighbours give the depth of the crouch. A script that
needs more force than people have is refused; one whose flight or touchdown comes earlier or later
than written is followed from when it does (:mod:`plantigrade.control.balance.flight`).

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
from plantigrade.control.balance.postures import PostureSolverSettings
from plantigrade.errors import ParameterError, known_names
from plantigrade.kinematics.foot_pose import MARKS, SEGMENTS, marks
from plantigrade.options import is_real
from plantigrade.toml import parse_toml, read_toml

MOTIONS = ("tiptoe", "tilt-inside", "tilt-outside", "circling", "one-foot", "jump")
"""Scripts that come with the package."""
MAX_DURATION, MAX_OFFSET = 600.0, 0.5  # [s, m] of a script, of an ankle or the body in it
RATE = 50.0  # [1/s] frames of the motion


@dataclass(frozen=True, kw_only=True)
class ScriptSettings:
    """How scripts become motions."""

    solver: PostureSolverSettings = PostureSolverSettings()
    """Postures over the feet."""
    max_force: float = 3.0
    """Greatest ground force a script may need [body weights]. Jumps for height take 2 to 2.5."""
    heel_rise_powers: tuple[float, float] = (3.0, 12.0)
    """Least and greatest power of time by which a heel rises before a flight. Chosen."""
    cop_spread: tuple[float, float] = (0.5, 0.15)
    """Standard deviation of pressure about ``toward``, along and across what presses. Chosen."""


@dataclass(frozen=True, eq=False)
class ScriptFrame:
    """Desired feet at a time."""

    time: float  #: The time [s]
    ankle: Float[Array, "2 3"]  #: Offset of each ankle from standing, right first [m]
    #: Which of :data:`~plantigrade.kinematics.foot_pose.MARKS` press, for each foot
    presses: Bool[Array, "2 n_marks"]
    body: Float[Array, " 3"]  #: Offset of the centre of mass from its default [m]
    #: Desired pressure within what presses of each foot, forward and to the left, from -1 to 1; NaN
    #: where that is left open
    toward: Float[Array, "2 2"]


@dataclass(frozen=True, eq=False)
class Script:
    """A script.

    Attributes:
        title: Its title.
        frames: Its frames, the first at time zero: standing.
    """

    title: str
    frames: tuple[ScriptFrame, ...]

    @property
    def duration(self) -> float:
        """Time of the last frame [s]."""
        return self.frames[-1].time


def script_named(word: str) -> Script:
    """Return one of :data:`MOTIONS`, or the script in a TOML file.

    Args:
        word: Name of a motion, or the file.

    Raises:
        ParameterError: If there is no such script, or it is no script.
    """
    if word in MOTIONS:
        text = files("plantigrade.control.balance").joinpath("motions", f"{word}.toml")
        return _read(Path(str(text)), word)
    if not word.endswith(".toml"):
        raise ParameterError(
            f"no motion {word!r}; {known_names(word, list(MOTIONS))}, or a TOML file"
        )
    return _read(Path(word), word)


def _read(path: Path, name: str) -> Script:
    table = parse_toml(read_toml(path), path)
    if unknown := set(table) - {"title", "frame"}:
        raise ParameterError(
            f"{name} says {', '.join(sorted(unknown))}; it may say title and frame"
        )
    rows = table.get("frame")
    if not isinstance(rows, list) or not rows:
        raise ParameterError(f"{name} has no [[frame]]")
    flat = np.tile(marks(*SEGMENTS), (2, 1))
    frames = [ScriptFrame(0.0, np.zeros((2, 3)), flat, np.zeros(3), np.full((2, 2), np.nan))]
    for i, row in enumerate(rows):
        where = f"{name}, frame {i + 1}"
        if not isinstance(row, Mapping):
            raise ParameterError(f"{where} is no table")
        frames.append(_frame(row, frames[-1], where))
    if frames[-1].time < (shortest := 2.0 / RATE):
        least = f"a script lasts {shortest:g} s at least"
        raise ParameterError(f"{name} ends at {frames[-1].time:g} s; {least}")
    return Script(str(table.get("title", name)), tuple(frames))


def _frame(row: Mapping[str, Any], before: ScriptFrame, where: str) -> ScriptFrame:
    """Return a frame; what it does not mention is as in the one before."""
    if unknown := set(row) - {"time", "right", "left", "both", "body"}:
        raise ParameterError(f"{where} says {', '.join(sorted(unknown))}")
    time, latest = row.get("time"), MAX_DURATION
    if time is None or not is_real(time) or not before.time < time <= latest:
        raise ParameterError(
            f"{where}: time={time!r} must be after {before.time:g} s and at most {latest:g} s"
        )
    ankle, presses, toward = before.ankle.copy(), before.presses.copy(), before.toward.copy()
    for word, feet in (("both", (0, 1)), ("right", (0,)), ("left", (1,))):
        entry = row.get(word, {})
        if not isinstance(entry, Mapping) or set(entry) - {"ankle", "presses", "toward"}:
            raise ParameterError(f"{where}: {word} may say ankle, presses and toward")
        for foot in feet:
            if "ankle" in entry:
                ankle[foot] = _numbers(entry["ankle"], 3, MAX_OFFSET, f"{where}: ankle [m]")
            if "toward" in entry:
                toward[foot] = _numbers(entry["toward"], 2, 1.0, f"{where}: toward")
            if "presses" in entry:
                names = entry["presses"]
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
        body = _numbers(row["body"], 3, MAX_OFFSET, f"{where}: body [m]")
    return ScriptFrame(float(time), ankle, presses, body, toward)


def _numbers(values: Any, n: int, most: float, where: str) -> Array:
    numbers = isinstance(values, list) and all(is_real(x) for x in values)
    if not numbers or len(values) != n or not np.abs(values).max() <= most:
        count = {2: "two", 3: "three"}[n]
        raise ParameterError(f"{where} is {count} numbers, none beyond {most:g}, not {values!r}")
    return np.array(values, dtype=float)
