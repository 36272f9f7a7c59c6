"""How settings are spelled on the command line: the word for a value, no default where none is.

Settings are dataclasses; a command inherits them, and each field becomes an option with the line
under it as its help.
"""

import math
from pathlib import Path
from typing import Annotated, Literal

import tyro


def optional(metavar: str):
    """Return the marker of an option that may be absent: its word in the help, no default shown."""
    return tyro.conf.arg(metavar=metavar, help_behavior_hint="")


Metres = Annotated[float | None, optional("METRES")]
Kilograms = Annotated[float | None, optional("KG")]
OptionalPath = Annotated[Path | None, optional("PATH")]
OptionalWord = Annotated[str | None, optional("TEXT")]
Sex = Annotated[Literal["female", "male"] | None, optional("{female,male}")]
Feet = Annotated[
    Literal["rigid", "two-segment", "multi-segment"] | None,
    optional("{rigid,two-segment,multi-segment}"),
]
Joints = Annotated[Literal["42", "43", "58", "66"] | None, optional("{42,43,58,66}")]
Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
Number = Annotated[float | None, optional("NUMBER")]
Seconds = Annotated[float | None, optional("S")]
Cadence = Annotated[float | None, optional("STEPS/MIN")]
Degrees = Annotated[
    float,
    tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar="DEG",
        instance_from_str=lambda words: math.radians(float(words[0])),
        is_instance=lambda value: isinstance(value, float),
        str_from_instance=lambda value: [f"{math.degrees(value):g}"],
    ),
]
"""An angle in radians that the command line takes and shows in degrees."""
