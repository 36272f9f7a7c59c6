"""Force files whose torques are about another point than they should be are read right."""

import numpy as np
import pytest

from plantigrade.io import read
from plantigrade.io.mot import read_mot
from tests.io.test_forces import write

FILES = [
    "gait2392_subject01/subject01_walk1_grf.mot",
    "opencap_subject4/squats1_grf.mot",
    "rajagopal_walk/grf_walk.mot",
    "running_subject04/run200_grf.mot",
]
CORNER = np.array([0.31, 0.0, -0.25])  # of a plate, in OpenSim's axes [m]


def rewritten(source, path, change):
    """Write the force file again with ``change(f, p, t)`` in place of the torques (axes: y up)."""
    lines = source.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("endheader")) + 1
    names = lines[start].split("\t")
    rows = np.array([line.split() for line in lines[start + 1 :] if line.strip()], float)
    for name in names:
        if not name.endswith("vx"):
            continue
        at = [names.index(name[:-2] + letter + x) for letter in "vp" for x in "xyz"]
        stem = name[:-2].replace("force", "torque")
        stem = stem if stem + "x" in names else name[:-2] + "m"
        to = [names.index(stem + x) for x in "xyz"]
        f, p, t = rows[:, at[:3]], rows[:, at[3:]], rows[:, to]
        rows[:, at[:3]], rows[:, at[3:]], rows[:, to] = change(f, p, t)
    body = ["\t".join(f"{x:.6f}" for x in row) for row in rows]
    path.write_text("\n".join([*lines[: start + 1], *body]) + "\n")
    return path


def origin(f, p, t):
    return f, p, t + np.cross(p, f)


def plate_side(f, p, t):
    return f, p, -(t + np.cross(p, f))


def all_down(f, p, t):
    return -f, p, -(t + np.cross(p, f))


def corner(f, p, t):
    return f, p, t + np.cross(p - CORNER, f)


def corner_alone(f, p, t):
    return f, np.tile(CORNER, (len(f), 1)), t + np.cross(p - CORNER, f)


def vertical_alone(f, p, t):
    return f, p, (t + np.cross(p, f)) * [0, 1, 0]


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (origin, "about the laboratory's origin"),
        (plate_side, "of the body on the plate"),
        (all_down, "about the laboratory's origin"),
        (corner_alone, ""),
    ],
)
@pytest.mark.parametrize("name", FILES)
def test_the_wrench_is_the_same_whatever_the_torque_is_about(data, tmp_path, name, change, word):
    path = data / "opensim" / name
    good, other = read_mot(path), read_mot(rewritten(path, tmp_path / path.name, change))
    assert any(word in note for note in other.warnings) or not word
    same_wrench(good, other)


@pytest.mark.parametrize("change", [corner, vertical_alone])
def test_origin_and_vertical_torque_of_walking_people_are_known_too(data, tmp_path, change):
    path = data / "opensim" / FILES[2]
    good, other = read_mot(path), read_mot(rewritten(path, tmp_path / path.name, change))
    assert any("converted" in note for note in other.warnings)
    same_wrench(good, other)


@pytest.mark.parametrize("name", FILES)
def test_torques_about_the_points_are_left_alone(data, name):
    assert not any("torques" in note for note in read_mot(data / "opensim" / name).warnings)


def same_wrench(good, other):
    """Centres of pressure to 5 mm and free moments to 2 N m where somebody stands on a plate."""
    for a, b in zip(good.plates, other.plates, strict=True):
        on = (a.force[:, 2] > 100) & np.isfinite(a.cop).all(axis=1)
        np.testing.assert_allclose(b.force[on], a.force[on], atol=1e-4)
        np.testing.assert_allclose(b.cop[on, :2], a.cop[on, :2], atol=5e-3)
        np.testing.assert_allclose(b.free_moment[on], a.free_moment[on], atol=2.0)


def test_moments_about_the_origin_in_a_table_of_motion_analysis(tmp_path):
    """Beside a foot that rolls over a plate 2 m away, its free moment is 3 N m."""
    s = np.linspace(-1, 1, 700)
    force = np.stack([120 * s, 30 * np.cos(s), 700 + 0 * s], axis=1)
    point = np.stack([2000 + 120 * s, 900 + 0 * s, 0 * s], axis=1)
    moment = np.cross(point, force)[:, 2] + 3000.0
    rows = np.hstack([force, point, moment[:, None], np.zeros((len(s), 7))])
    found = read(write(tmp_path / "walk.forces", rows))
    assert any("laboratory's origin" in note for note in found.warnings)
    np.testing.assert_allclose(found.plates[0].free_moment, 3.0, atol=0.02)
