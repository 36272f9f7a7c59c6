"""The virtual contact plate: discs where the feet press, as large as they press."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.pages.contact_plate import (
    DISC_LOAD,
    DISC_RADIUS,
    SCALE,
    SoleOutline,
    foot_svg,
    plate_svg,
)
from plantigrade.pages.section import ReportedRun
from plantigrade.pages.sections.plate import longest, plate_section
from plantigrade.record import Record, Run

HUMAN = Human.create(1.7, 65.0, "female", "42", "two-segment")
SITES = contact_sites(HUMAN)
NAMES = [site.name for site in SITES]
HEEL = next(i for i, s in enumerate(SITES) if "heel_back_lateral_r" in s.name)
TOE = next(i for i, s in enumerate(SITES) if "toe_1_r" in s.name)
DISC = r'cx="([\d.-]+)" cy="([\d.-]+)" r="([\d.]+)" style="fill'


def discs(svg: str) -> np.ndarray:
    """Return centre and radius of every disc [px]."""
    return np.array(re.findall(DISC, svg), dtype=float)


@pytest.fixture
def rolled():
    """A record whose right foot rolls from heel to toe between 0.2 and 0.7 s."""
    time = np.arange(0.0, 1.001, 0.1)
    qpos = np.tile(HUMAN.standing(), (len(time), 1))
    motion = Motion(time, qpos, np.zeros((len(time), HUMAN.model.nv)), HUMAN.joint_names)
    force = np.zeros((len(time), len(SITES), 3))
    weight = HUMAN.mass * 9.81
    u = np.linspace(0.0, 1.0, 6)
    force[2:8, HEEL, 2], force[2:8, TOE, 2] = weight * (1 - u), weight * u
    return Record(HUMAN, motion, sites=SITES, contact_force=force)


def section(record: Record):
    """Return its section."""
    found = plate_section(ReportedRun(Run(record, "simulate", title="x", sentence="x", figures={})))
    assert len(found) <= 1
    return found[0] if found else None


def test_a_disc_is_as_large_as_the_load_and_lies_where_it_presses():
    sole = SoleOutline.of(HUMAN, SITES, "r")
    load = np.zeros(len(SITES))
    load[HEEL], load[TOE] = DISC_LOAD, 0.25 * DISC_LOAD
    drawn = discs(foot_svg(sole, sole.place, load[sole.index], ""))
    np.testing.assert_allclose(
        sorted(drawn[:, 2]), [0.5 * SCALE * DISC_RADIUS, SCALE * DISC_RADIUS], atol=0.06
    )
    heel, toe = drawn[np.argsort(-drawn[:, 2])]
    assert heel[1] - toe[1] > 0.6 * SCALE * HUMAN.dimensions.foot_length  # toes up
    assert heel[0] > toe[0]  # of the right foot the outer edge is on the right


def test_the_left_foot_is_on_the_left():
    soles = [SoleOutline.of(HUMAN, SITES, side) for side in "rl"]
    load = np.where([s.side == "l" for s in SITES], 0.1, 0.05)
    drawn = plate_svg(soles, load)
    assert drawn.index("left 70 %") < drawn.index("right 35 %")


def test_a_foot_is_drawn_through_its_contact(rolled):
    found = section(rolled)
    (figure,) = found.figures  # the left foot is not loaded
    assert "from 0.20 to 0.70 s" in figure.caption
    times = re.findall(r">([\d.]+) s</text>", figure.svg)
    assert times == [f"0.{k}0" for k in range(2, 8)]
    (group,) = found.groups
    rows = {row[0]: row[1:] for row in group.rows}
    assert rows["foot heel back lateral"] == ("1.00", "0.50", "83")
    path = re.search(r'polyline points="([^"]+)"', figure.svg)[1].split()
    heights = [float(point.split(",")[1]) for point in path]
    assert len(heights) == 6 and (np.diff(heights) < 0).all()  # towards the toes


def test_a_measured_force_is_drawn_where_it_acts_on_a_turned_foot(rolled):
    plate = replace(SITES[HEEL], name="plate", measured=True, position=(0.0, 0.0, 0.0))
    qpos = rolled.motion.qpos.copy()
    qpos[:, 0] += 1.0
    qpos[:, 7 + HUMAN.hinge("ankle_angle_r")] = 0.3
    at = BodyState(HUMAN, qpos[0]).position(
        PointSet.of(HUMAN, [replace(plate, position=SITES[HEEL].position)])
    )
    n = len(qpos)
    record = Record(
        HUMAN,
        replace(rolled.motion, qpos=qpos),
        sites=(plate,),
        contact_force=rolled.contact_force[:, [HEEL]],
        contact_point=np.tile(at, (n, 1, 1)),
    )
    sole, spheres = SoleOutline.of(HUMAN, record.sites, "r"), SoleOutline.of(HUMAN, SITES, "r")
    there = spheres.place[list(spheres.index).index(HEEL)]
    np.testing.assert_allclose(sole.places(record, 3)[0], there, atol=1e-9)
    found = section(record)
    assert "Measured forces" in found.text and not found.groups
    unknown = replace(record, contact_point=np.full((n, 1, 3), np.nan))
    assert section(unknown).missing


def test_without_forces_at_the_feet_there_is_no_plate(rolled):
    assert section(replace(rolled, contact_force=None, sites=())) is None
    assert section(replace(rolled, contact_force=0.0 * rolled.contact_force)).missing


def test_a_contact_that_is_cut_is_taken_only_where_no_other_is():
    assert longest(np.array([True, True, True])) == (0, 2)
    assert longest(np.array([True, True, True, False, True, False])) == (4, 4)
    assert longest(np.zeros(3, bool)) is None
