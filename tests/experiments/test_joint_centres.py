"""What joint centres of a reference add to knee flexion."""

import numpy as np
import pytest

from experiments.joint_centres import CENTRES, COLUMNS, centre_rows
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import body_paths
from tests.analyze.plated_walk import analyse, plated_walk


@pytest.fixture(scope="module")
def walk():
    """A walk with its joint centres, and the axes of the right thigh."""
    trial = analyse(plated_walk().fit())
    human, paths, axes = trial.fit.human, {}, {}
    for side in SIDES:
        bodies = [human.body(f"{body}_{side}") for body in ("femur", "tibia", "foot")]
        origin, turned = body_paths(human, trial.fit.qpos, bodies)
        paths |= {f"{centre}_{side}": origin[:, k] for k, centre in enumerate(CENTRES)}
        axes[side] = turned[:, 0]
    return trial, paths, axes["r"]


def shares(walk, theirs):
    return {row.quantity: row.value for row in centre_rows("walk.c3d", walk[0], theirs)}


def test_the_same_centres_add_nothing(walk):
    found = shares(walk, walk[1])
    assert tuple(found) == COLUMNS
    zeros = [value for name, value in found.items() if "zero" not in name]
    np.testing.assert_allclose(zeros, 0.0, atol=1e-9)


def test_a_knee_centre_further_back_is_a_straighter_knee(walk):
    trial, paths, thigh = walk
    back = dict(paths, knee_r=paths["knee_r"] - 0.01 * thigh[:, :, 0])
    found = shares(walk, back)
    d = trial.fit.human.dimensions
    usual = np.rad2deg(0.01 * (1 / d.thigh + 1 / d.shank))  # of a straight leg
    assert found[COLUMNS[1]] == pytest.approx(usual, rel=0.1)
    assert found[COLUMNS[3]] == pytest.approx(found[COLUMNS[1]], abs=1e-9)
    assert found[COLUMNS[0]] == pytest.approx(0.0, abs=1e-9)


def test_a_side_without_centres_has_no_rows(walk):
    right = {name: path for name, path in walk[1].items() if name.endswith("r")}
    assert tuple(shares(walk, right)) == COLUMNS[:5]
