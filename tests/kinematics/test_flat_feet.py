"""Feet that stand flat: wrong zeros, shoes and missing floors are found from where feet rest."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.fitted_soles import height_figures, heights_in_stance
from plantigrade.kinematics.flat_feet import set_flat, with_resting_soles
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.textbook_recording import recorded, textbook_walk
from plantigrade.kinematics.unmeasured_toes import toes_on_ground
from plantigrade.models.landmarks import attachments
from tests.models.presets import person

RATE = 100.0
SHOWN = "asis psis thigh knee_lateral knee_medial shank ankle_lateral ankle_medial".split()
FOOT = "heel metatarsal_1_head metatarsal_2_head metatarsal_5_head".split()
NONE = np.empty((0, 2 * (len(SHOWN) + len(FOOT)), 3))


@pytest.fixture(scope="module")
def walk():
    return textbook_walk(person("42", "two-segment"), cycles=2)


@pytest.fixture(scope="module")
def places(walk):
    table = attachments(walk.human)
    return tuple(table[f"{mark}_{side}"] for mark in (*SHOWN, *FOOT) for side in "rl")


def turned(walk, places, joint, degrees):
    """The same places with the markers of the right foot turned about a joint."""
    body = next(b for b in walk.human.skeleton.bodies if b.name == "foot_r")
    axis = next(h.axis for h in body.hinges if h.name == f"{joint}_r")
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * axis)
    return tuple(
        replace(p, position=turn.apply(p.position)) if p.body == "foot_r" else p for p in places
    )


def markers(walk, places, lift=0.0):
    return PointSet.of(walk.human, places).path(walk.qpos) + [0.0, 0.0, lift]


def feet(walk, places, samples):
    return set_flat(walk.human, places, samples, NONE, RATE, walk.qpos[0])


@pytest.mark.parametrize(("joint", "degrees"), [("ankle_angle", 8.0), ("subtalar_angle", 15.0)])
def test_a_foot_turned_by_its_markers_is_set_level(walk, places, joint, degrees):
    """Also about the vertical, about which an oblique joint turned it too."""
    found = feet(walk, turned(walk, places, joint, degrees), markers(walk, places))
    assert found.grounded and not found.notes
    for mine, true in zip(found.places, places, strict=True):
        assert np.linalg.norm(mine.position - true.position) < 0.008


def test_noise_of_a_millimetre_changes_little(walk, places):
    samples = markers(walk, places)
    samples = samples + 0.001 * np.random.default_rng(3).normal(size=samples.shape)
    found = feet(walk, turned(walk, places, "ankle_angle", 8.0), samples)
    for mine, true in zip(found.places, places, strict=True):
        assert np.linalg.norm(mine.position - true.position) < 0.008


def test_feet_that_stand_flat_stay_as_they_are(walk, places):
    found = feet(walk, places, markers(walk, places))
    lift = found.human.dimensions.ankle_height - walk.human.dimensions.ankle_height
    for side in "rl":
        sole = next(
            v for k, v in found.human.soles.items() if k.endswith(f"heel_back_medial_{side}")
        )
        assert sole - lift == pytest.approx(0.0, abs=0.003)
    assert found.human.height == pytest.approx(walk.human.height)


def test_the_ground_of_shoes_is_below_them(walk, places):
    found = feet(walk, places, markers(walk, places, lift=0.03))
    assert any("soles of that thickness" in note for note in found.notes)
    qpos = walk.qpos + np.eye(walk.qpos.shape[1])[2] * 0.03
    human = with_resting_soles(found.human, places, np.arange(len(qpos)) / RATE, qpos)
    standing = sole_paths(walk.human, walk.qpos)
    stance = np.stack(
        [standing.position[:, standing.of(s), 2].min(axis=1) < 0.001 for s in "rl"], axis=1
    )
    figures = height_figures(heights_in_stance(sole_paths(human, qpos), stance))
    assert abs(figures["sole_in_stance_mean_mm"]) < 3
    bare = height_figures(heights_in_stance(sole_paths(walk.human, qpos), stance))
    assert bare["sole_in_stance_mean_mm"] > 25


def test_a_foot_in_equinus_is_not_set_level(walk, places):
    qpos = walk.human.standing()
    qpos[7 + walk.human.hinge("ankle_angle_r")] = -0.35
    found = feet(walk, places, PointSet.of(walk.human, places).path(np.tile(qpos, (60, 1))))
    assert any("right foot rests" in note and "not assumed" in note for note in found.notes)
    right = [i for i, p in enumerate(places) if p.body == "foot_r"]
    for i in right:
        np.testing.assert_allclose(found.places[i].position, places[i].position)


def test_a_floor_elsewhere_is_said_and_changes_nothing(walk, places):
    found = feet(walk, places, markers(walk, places, lift=0.4))
    assert not found.grounded and "the floor is elsewhere" in found.notes[0]
    assert found.human is walk.human and abs(found.above_ground - 0.4) < 0.02


def test_a_floor_elsewhere_is_found_without_plates(walk, tmp_path):
    recording = recorded(walk, tmp_path / "walk.c3d")
    lifted = recording.markers.positions + [0.0, 0.0, 0.12]
    higher = replace(recording, markers=replace(recording.markers, positions=lifted))
    fit = fit_markers(higher)
    assert abs(fit.ground.height - 0.12) < 0.02
    assert any("12" in note and "the floor was put there" in note for note in fit.warnings)
    soles = sole_paths(fit.human, fit.qpos).position[..., 2].min(axis=1)
    assert abs(np.median(soles) - fit.ground.height) < 0.005


def test_markers_of_one_end_of_the_foot_tell_nothing(walk, places):
    some = [i for i, p in enumerate(places) if p.body[:4] != "foot" or p.position[0] > 0.05]
    shown = tuple(places[i] for i in some)
    found = set_flat(
        walk.human, shown, markers(walk, places)[:, some], NONE[:, some], RATE, walk.qpos[0]
    )
    assert found.human is walk.human and found.places == shown and not found.grounded


def test_toes_without_markers_bend_where_the_ground_bends_them(walk, places):
    human, straight = walk.human, np.array(walk.qpos)
    for side in "rl":
        straight[:, 7 + human.hinge(f"mtp_angle_{side}")] = 0.0
    bent = toes_on_ground(human, places, straight)

    def toes(qpos):
        soles = sole_paths(human, qpos)
        return soles.position[:, [*soles.of("r", "toes"), *soles.of("l", "toes")], 2]

    assert toes(straight).min() < -0.02 and toes(bent).min() > -0.002
    up = toes(straight).min(axis=1) > 0.0
    np.testing.assert_array_equal(bent[up], straight[up])
    seen = (*places, attachments(human)["hallux_r"], attachments(human)["hallux_l"])
    np.testing.assert_array_equal(toes_on_ground(human, seen, straight), straight)
