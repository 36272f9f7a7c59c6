r"""The four motions of the paper, their settings as data (section VI).

**Where the text contradicts itself**, this is what was chosen and why.

- *Sample times.* Still-walk-still is to have a step of 0.5 s, a duration of 3 s and 7 sampling
  intervals; 7 × 0.5 s is not 3 s. The contact matrix is 6 × 7, so 7 sample *times* are meant, 6
  intervals. The counts of constraints agree: 86 limits each of coordinates, rates and generalised
  forces, 12 of penetration and 4 of the zero-moment point at each of 6 sample times, and 72
  (equations counted as two inequalities) for each of 12 feet on the ground, make 2508 for
  sit-stand, the printed number; two feet less and the pelvis' velocity at the 4 inner times make
  2372 for the side-step, the printed number. (Boundary conditions are not counted.)
- *Knots.* 430, 387, 387 and 301 variables are 43 × 10, 9, 9 and 7 coefficients, one more than one
  knot at each sample time gives. The formula of the knot vector,
  :math:`[0\,0\,0\,0\,t_1 \dots t_\mathrm{sim}\,t_\mathrm{sim}\,t_\mathrm{sim}\,t_\mathrm{sim}]`,
  can be read with one knot too many at the end, whose coefficient would do nothing. Here as many
  coefficients are there as printed, and all of them count: the pieces are of equal length, one
  more than sampling intervals. Knots are therefore not sample times.
- *Contact of the walk.* The matrices printed for the 7 times have 6 columns,
  ``1 1 1 1 0 1`` (right) and ``1 1 0 1 1 1`` (left), but the number of constraints implies 12 feet
  on the ground: one column of ones is missing in each. With it at the end they are what the text
  says: half a step with the right foot, before the first sample after the start; a full step left
  through the air at 1.0 s; a full step right through the air at 2.0 s; half a step left, before the
  last sample. *The half steps have no sample in the air.* Nothing keeps these feet off the ground
  between the samples, and the check reports the depth.
- *Contact of the jump.* Its matrices are 6 × 5 for 4 sample times. All of it is ones; four columns.
- *The end of the jump.* All coordinates and rates are to be zero at the end, the pelvis' speed up
  is to be 2 m/s, and all points of the feet are to stand still. For a body that moves up as a whole
  the feet do, too: no-slip (23) is left out at the last sample. The result the paper reports is
  1.8 m/s, not 2 m/s, and with a given speed Eq. 28 would be a constant; so the speed is free, at
  most 2 m/s. Feet that are on the ground and at rest at the sample before, and on the ground and
  moving up at the last, must have been below it between them: as the check finds.
- *Limits.* The knee is to bend by at most 60° and, in mid-swing, by at least 60°; an equation, and
  sitting needs 90°. It may bend to 120° here, as the elbows may. Limits are "adjusted accordingly"
  for sitting and the side-step: the pelvis may move 0.05 m beyond where the motion starts and ends;
  in the jump it may also sink by 0.44 m, without which the body cannot sit before it jumps. The
  vertical force of the root, limited to 1.4 body weights upwards, must not be negative.
- *Pelvis velocity.* No limits are given: a half and twice the mean speed here; where the motion
  starts and ends it is at rest, so they hold at the samples between. For the side-step, 1 s long
  and at rest at both ends, a quarter and three times.
- *Sitting.* There is no chair. From rest the body would fall backwards; only the acceleration of
  the first instant, which boundary conditions leave free, holds the zero-moment point in the feet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.data_files import toml_tree
from plantigrade.errors import ParameterError


@dataclass(frozen=True)
class Printed:
    """Values reported by the paper for a motion."""

    variables: int
    constraints: int
    seconds: float  # time of the solver [s]


@dataclass(frozen=True)
class PaperMotion:
    """One motion as the paper sets it."""

    name: str
    duration: float  # how long it lasts [s]
    step: float  # time between samples [s]
    n_coefficients: int  # coefficients of a coordinate
    right: str  # row of Λ for the right foot, the same for its six points: one figure a sample
    left: str  # the same for the left foot
    # how far ahead of its place in the neutral pose the right foot stands at those samples [m]
    right_places: tuple[float, ...]
    left_places: tuple[float, ...]  # the same for the left foot
    printed: Printed  # what the paper reports
    sideways: bool = False  # whether feet go to the right instead
    start: str = "neutral"  # ``"neutral"`` or ``"seated"``
    # how far the pelvis gets (forward, to the right) [m]; of a motion that starts seated, None: by
    # as much as the thighs are long
    travel: tuple[float, float] | None = None
    sink: float = 0.05  # how far the pelvis may go below where it starts and ends [m]
    leeway: float = 0.05  # how far it may leave the way from start to end otherwise [m]
    # lower and upper limit of the pelvis' speed (Eq. 20) [m/s]; None where switched off
    speed: tuple[float, float] | None = None
    arms: bool = False  # whether arms and legs are coupled (Eq. 26)
    knee: bool = False  # whether a swinging knee bends by 60° (Eq. 27)
    jump: float = 0.0  # weight η of the height of the jump (Eq. 28) [1/m]; zero for none
    take_off: float = 0.0  # largest speed up at the end [m/s]
    title: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)

    @property
    def n_samples(self) -> int:
        """Sample times."""
        return round(self.duration / self.step) + 1

    @property
    def times(self) -> Float[Array, " n_samples"]:
        """Sample times [s]."""
        return np.linspace(0.0, self.duration, self.n_samples)

    @property
    def contact(self) -> dict[str, tuple[bool, ...]]:
        """Whether each foot stands at each sample: a row of Λ."""
        return {"r": tuple(c == "1" for c in self.right), "l": tuple(c == "1" for c in self.left)}

    @property
    def places(self) -> dict[str, Float[Array, "n_samples 2"]]:
        """Where each foot stands at each sample (forward, to the right) [m]."""
        axis = [0.0, 1.0] if self.sideways else [1.0, 0.0]
        ways = {"r": self.right_places, "l": self.left_places}
        return {side: np.outer(way, axis) for side, way in ways.items()}


def _motion(name: str, row: dict[str, Any]) -> PaperMotion:
    """Return a motion from its entry in the file."""
    reach = row.pop("reach", 0.0)
    for key in {"right_places", "left_places", "travel", "speed"} & set(row):
        row[key] = tuple(reach * steps for steps in row[key])
    row["printed"] = Printed(**row["printed"])
    return PaperMotion(name, **row)


MOTIONS = {
    name: _motion(name, row)
    for name, row in toml_tree("plantigrade.trajopt.zhakatayev2023", "motions.toml").items()
}
"""The paper's motions by the names our tasks have."""


def paper_task(name: str) -> PaperMotion:
    """Return a motion by name.

    Raises:
        ParameterError: If the paper has none of that name.
    """
    if name not in MOTIONS:
        raise ParameterError(f"the paper has no motion {name!r}; it has {', '.join(MOTIONS)}")
    return MOTIONS[name]
