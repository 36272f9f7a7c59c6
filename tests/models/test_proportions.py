"""Proportions of the average person compared with the men and women of ANSUR II."""

import csv

import numpy as np
import pytest

from plantigrade.models.anthropometry import dimensions
from plantigrade.models.feet import point, sphere_radius
from plantigrade.models.landmarks import landmarks
from plantigrade.models.skeleton import all_parts
from tests.models.presets import SEXES

# de Leva 1996 (Journal of Biomechanics 29, 1231-1233): joint centres between acromion and radiale,
# and the wrist below the stylion, fractions of these lengths and of stature.
SHOULDER, ELBOW, WRIST = 0.104, 0.957, 0.0011


def measured(sex: str) -> dict[str, float]:
    """Return the average person's measures under ANSUR's names, fractions of stature."""
    d = dimensions(1.0, sex)
    origin = {"": np.zeros(3)}
    parts = {p.name: p for p in all_parts(d, sex, 70.0, "rigid")}
    for name, part in parts.items():
        origin[name] = origin[part.parent] + part.position
    lift = d.ankle_height - origin["foot_r"][2]
    height = {name: x[2] + lift for name, x in origin.items()}
    marks = landmarks(d)
    back = height["abdomen"]
    arm = d.upper_arm / (ELBOW - SHOULDER)
    skull = parts["head"].solids[0]
    heel = point("heel_back_medial", d)[0] - sphere_radius(d)
    breadth = point("metatarsal_5", d)[1] - point("metatarsal_1", d)[1] + 2 * sphere_radius(d)
    return {
        "cervicaleheight": back + marks["c7"].position[2],
        "suprasternaleheight": back + marks["suprasternale"].position[2],
        "acromialheight": height["humerus_r"] + SHOULDER * arm,
        "acromionradialelength": arm,
        "radialestylionlength": d.forearm - (1 - ELBOW) * arm - WRIST,
        "handlength": d.hand + WRIST,
        "wristheight": height["hand_r"] + WRIST,
        "lateralfemoralepicondyleheight": height["tibia_r"],
        "footlength": d.foot_length,
        "balloffootlength": point("metatarsal_1", d)[0] - heel,
        "footbreadthhorizontal": breadth,
        "headlength": 2 * skull.b[0],
        "headbreadth": 2 * skull.b[1],
        "tragiontopofhead": d.head - marks["ear_r"].position[2],
    }


@pytest.fixture(scope="module", params=SEXES)
def survey(request, data):
    """Measures over stature of every person of one sex."""
    path = data / f"anthropometry/ansur2/ANSUR_II_{request.param.upper()}_Public.csv"
    if not path.is_file():
        pytest.skip(f"no {path.name}")
    with path.open(encoding="latin-1", newline="") as file:
        people = list(csv.DictReader(file))
    stature = np.array([float(p["stature"]) for p in people])
    names = measured(request.param)
    return request.param, {n: np.array([float(p[n]) for p in people]) / stature for n in names}


@pytest.mark.parametrize("name", measured("male"))
def test_the_average_person_is_within_the_middle_half_of_people(survey, name):
    sex, shares = survey
    low, high = np.percentile(shares[name], [25, 75])
    assert low <= measured(sex)[name] <= high


@pytest.mark.parametrize("sex", SEXES)
def test_the_middle_of_the_arm_hangs_between_shoulder_and_hip(sex):
    """Finger tips reach mid-thigh, 0.36 to 0.40 of stature above the ground."""
    found = measured(sex)
    assert 0.35 < found["wristheight"] - found["handlength"] < 0.40
