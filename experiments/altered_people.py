"""People with other leg lengths or another strength."""

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plantigrade.kinematics.transfer import leg_length
from plantigrade.models import Human

LEGS = ("thigh", "shank")


def scaled_legs(human: Human, times: float) -> Human:
    """Return a person with scaled thighs and shanks; all other lengths stay.

    Raises:
        ParameterError: If there can be no such person.
    """
    description = human.to_dict()
    lengths = {n: v * (times if n in LEGS else 1.0) for n, v in description["lengths"].items()}
    height = description["height"] + (times - 1.0) * leg_length(human)
    return Human.from_dict({**description, "height": height, "lengths": lengths, "soles": {}})


def scaled_strength(human: Human, times: float) -> Human:
    """Return a person with scaled joint strength; a run folder does not store the scale."""

    def stronger(found: re.Match[str]) -> str:
        most = " ".join(f"{times * float(x):.8g}" for x in found[1].split())
        return f'actuatorfrcrange="{most}"'

    if times == 1.0:
        return human
    return replace(human, xml=re.sub(r'actuatorfrcrange="([^"]*)"', stronger, human.xml))


def torque_limits(human: Human) -> Mapping[str, tuple[float, float]]:
    """Return the torque limits of the hinges of one leg and the trunk [N m]."""
    ranges = np.array(human.model.jnt_actfrcrange[1:])
    named = dict(zip(human.coordinates, ranges.tolist(), strict=True))
    return {
        n.removesuffix("_r"): (float(r[0]), float(r[1]))
        for n, r in named.items()
        if n.endswith("_r") or n.startswith("lumbar")
    }
