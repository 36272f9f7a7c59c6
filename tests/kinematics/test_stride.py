"""One stride of a walk, whichever way it was walked."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.kinematics.posture import leans
from plantigrade.kinematics.stride import stride_of
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.spatial.conventions import about_vertical, rotation_matrix, turned


@pytest.fixture(scope="module")
def walker():
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    book = textbook_walk(human, speed=1.2, rate=60.0, cycles=2)
    rest = np.zeros((len(book.time), human.model.nv))
    return human, Motion(book.time, book.qpos, rest, human.joint_names, events=book.events)


@pytest.mark.parametrize("heading", [0.1, 1.5, np.pi, -2.5])
def test_a_stride_is_the_same_whichever_way_it_was_walked(walker, heading):
    human, walk = walker
    assert leans(human, walk.qpos, "asis_r")[:, 0].mean() > 5.0  # a lean that could be turned aside
    qpos = walk.qpos.copy()
    qpos[:, :3] = qpos[:, :3] @ about_vertical(heading).T
    qpos[:, 3:7] = turned(qpos[:, 3:7], heading)
    expected, found = stride_of(human, walk), stride_of(human, replace(walk, qpos=qpos))
    assert found.cyclic and found.length == pytest.approx(expected.length)
    np.testing.assert_allclose(found.qpos[:, :3], expected.qpos[:, :3], atol=1e-6)
    R, own = (rotation_matrix(stride.qpos[:, 3:7]) for stride in (found, expected))
    np.testing.assert_allclose(R, own, atol=1e-6)
