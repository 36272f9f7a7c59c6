"""The three feet: common outline, and the multi-segment foot of its paper."""

import mujoco
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from plantigrade.errors import ParameterError
from plantigrade.models import FEET, Human
from plantigrade.models.anthropometry import DE_LEVA, dimensions
from plantigrade.models.feet import foot_parts, point, sphere_radius
from tests.models.presets import person

SEGMENTS = {  # the paper's five segments
    "medial_metatarsal",
    "medial_phalanges",
    "lateral_metatarsal",
    "lateral_phalanges",
    "heel",
}


@pytest.fixture(scope="module")
def d():
    return dimensions(1.74)


@pytest.fixture(scope="module")
def left(d):
    parts = foot_parts("multi-segment", d, "male", 70.0)
    return [p for p in parts if p.name.endswith("_l")]


def absolute(parts):
    """Origins of parts in the ankle frame."""
    origin = {}
    for p in parts:
        origin[p.name] = origin.get(p.parent, np.zeros(3)) + p.position
    return origin


def test_sixteen_bones_of_one_radius_in_five_segments(d, left):
    bones = [s for p in left for s in p.solids]
    assert len(bones) == 16
    assert {b.kind for b in bones} == {"capsule"}
    assert {b.radius for b in bones} == {sphere_radius(d)}
    names = {p.name.removesuffix("_l") for p in left}
    assert len(left) == 5 and names - {"foot"} == SEGMENTS - {"medial_metatarsal"}


def test_phalanges_metatarsals_and_heel_bones_are_as_many_as_in_the_paper(left):
    count = {p.name[:-2]: len(p.solids) for p in left}
    assert count["medial_phalanges"] + count["lateral_phalanges"] == 5
    assert count["heel"] == 2
    assert count["lateral_metatarsal"] == 2
    assert count["foot"] == 7  # three metatarsals and four tarsal bones


def test_four_joints_of_three_turns_where_the_paper_puts_them(d, left):
    human = Human.create(joints="66")
    for part, where in (
        ("medial_phalanges", "metatarsal_3"),  # third metatarsal and phalanges
        ("lateral_phalanges", "metatarsal_4"),  # fourth metatarsal and phalanges
        ("lateral_metatarsal", "base_4"),  # fourth metatarsal and cuboid
        ("heel", "heel"),
    ):
        np.testing.assert_allclose(absolute(left)[f"{part}_l"], point(where, d), atol=1e-15)
        for side in ("r", "l"):
            body = human.model.body(f"{part}_{side}")
            assert body.jntnum[0] == 3
    inside = [c for c in human.coordinates if c.startswith(("mtp", "cuboid", "heel"))]
    assert len(inside) == 24


def test_the_joints_lie_at_the_height_of_the_contact_spheres(d, left):
    for name, origin in absolute(left).items():
        if name != "foot_l":
            assert origin[2] + d.ankle_height == pytest.approx(sphere_radius(d))


def test_contact_is_at_bone_ends_alone(left):
    for p in left:
        ends = np.array([e for s in p.solids for e in (s.a, s.b)])
        for c in p.contacts:
            assert np.linalg.norm(ends - c.position, axis=1).min() < 1e-12


def test_segments_on_the_ground_have_three_contacts_and_ten_are_in_the_toes(d, left):
    """Shared ends count for both segments; the medial metatarsals do not touch."""
    origin = absolute(left)
    places = np.array([origin[p.name] + c.position for p in left for c in p.contacts])
    for p in left:
        ends = np.array([origin[p.name] + e for s in p.solids for e in (s.a, s.b)])
        low = ends[np.abs(ends[:, 2] + d.ankle_height - sphere_radius(d)) < 1e-9]
        shared = sum(np.linalg.norm(low - x, axis=1).min() < 1e-9 for x in places)
        if p.name != "foot_l":
            assert shared >= 3, p.name
    assert not next(p for p in left if p.name == "foot_l").contacts
    toes = [c for p in left if "phalanges" in p.name for c in p.contacts]
    assert len(toes) == 10
    assert len(places) == 16
    assert len(np.unique(places.round(9), axis=0)) == 16


def test_the_mass_goes_with_the_volume_of_the_bones(left):
    lengths = [sum(np.linalg.norm(s.b - s.a) for s in p.solids) for p in left]
    masses = [p.inertia.mass for p in left]
    np.testing.assert_allclose(np.divide(masses, sum(masses)), np.divide(lengths, sum(lengths)))
    assert sum(masses) == pytest.approx(70.0 * DE_LEVA["male"]["foot"].mass)


@pytest.mark.parametrize("feet", FEET)
def test_length_and_width_scale_the_foot(feet):
    def extent(**lengths):
        human = Human.create(1.74, 71.0, "male", "42", feet, lengths)
        data = mujoco.MjData(human.model)
        data.qpos = human.standing()
        mujoco.mj_forward(human.model, data)
        x = [data.geom(name).xpos.copy() for name, side, _ in human.contact_points if side == "l"]
        return np.ptp(np.array(x), axis=0)

    usual = extent(foot_length=0.26, foot_width=0.10)
    np.testing.assert_allclose(extent(foot_length=0.13, foot_width=0.10)[0], usual[0] / 2)
    np.testing.assert_allclose(extent(foot_length=0.26, foot_width=0.05)[1], usual[1] / 2)


@pytest.mark.parametrize("feet", FEET)
def test_contacts_span_the_length_given(feet):
    """Sphere to sphere, back of the heel to the tip of the toes: within 6 % of the foot."""
    human = Human.create(1.74, 71.0, "male", "42", feet, {"foot_length": 0.26})
    data = mujoco.MjData(human.model)
    data.qpos = human.standing()
    mujoco.mj_forward(human.model, data)
    geoms = [human.model.geom(n).id for n, side, _ in human.contact_points if side == "l"]
    x, r = data.geom_xpos[geoms, 0], human.model.geom_size[geoms, 0]
    assert (x + r).max() - (x - r).min() == pytest.approx(0.26, rel=0.06)


def test_all_feet_stand_on_one_hull():
    """The same outline: areas of support differ by less than a tenth."""
    areas = []
    for feet in FEET:
        human = person("42", feet)
        data = mujoco.MjData(human.model)
        data.qpos = human.standing()
        mujoco.mj_forward(human.model, data)
        x = np.array([data.geom(n).xpos[:2] for n, side, _ in human.contact_points if side == "l"])
        areas.append(ConvexHull(x).volume)
    assert max(areas) / min(areas) < 1.1


def test_with_a_full_sole_all_feet_touch_at_the_same_points_and_weigh_the_same():
    found, masses = [], []
    for feet in FEET:
        human = Human.create(1.5, 48.5, "female", "66", feet, full_sole=True)
        data = mujoco.MjData(human.model)
        data.qpos = human.standing()
        mujoco.mj_forward(human.model, data)
        foot = human.body("foot_l")
        masses.append(human.model.body_subtreemass[foot])
        names = [n for n, side, _ in human.contact_points if side == "l"]
        x = np.array([data.geom(n).xpos for n in names]) - data.xpos[foot]
        found.append(x[np.lexsort(x.round(9).T)])
    assert found[0].shape == (16, 3)
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=1e-12)
    np.testing.assert_allclose(masses, masses[0])
    assert Human.from_dict(human.to_dict()).full_sole
    assert not Human.from_dict(Human.create(joints="42").to_dict()).full_sole


def test_the_table_is_of_the_length_it_says():
    d = dimensions(1.74, "male", {"foot_length": 0.24})
    tip, back = point("toe_2", d)[0], point("heel_back_medial", d)[0]
    assert tip - back + 2 * sphere_radius(d) == pytest.approx(0.24, rel=1e-9)


def test_an_unknown_foot_raises(d):
    with pytest.raises(ParameterError, match="allowed are rigid, two-segment, multi-segment"):
        foot_parts("hoof", d, "male", 70.0)
