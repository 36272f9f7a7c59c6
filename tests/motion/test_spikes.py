"""Single samples far off their curve are errors of the file; kicks, bounces and steps are not."""

import numpy as np
import pytest

from plantigrade.io import read
from plantigrade.kinematics.coordinate_fit import fit_coordinates
from plantigrade.motion.spikes import MIN_ROTATION, spikes, without_spikes
from plantigrade.workflows.fit import fit_trial

TIME = np.arange(240) / 120
SWING = 0.6 * np.sin(2 * np.pi * TIME)


@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("leap", [0.15, -1.5])
def test_a_spike_is_found_where_it_is(width, leap):
    curve = SWING.copy()
    curve[77 : 77 + width] += leap
    ((at, size),) = spikes(curve, MIN_ROTATION)
    assert (at.start, at.stop) == (77, 77 + width)
    assert size == pytest.approx(abs(leap), abs=0.02)


@pytest.mark.parametrize(
    "curve",
    [
        SWING,
        np.cumsum(26.0 * np.exp(-(((TIME - 1) / 0.05) ** 2))) / 120,  # a kick at 1500 deg/s
        2.0 * np.abs(TIME - 1),  # an end stop
        12.0 * np.abs(TIME - 1),  # the same, faster than any joint
        np.where(TIME < 1, 0.0, 0.5),  # labels exchanged from here on
        np.random.default_rng(3).normal(0, 0.03, 240),  # noise of 2 degrees throughout
    ],
)
def test_what_people_do_is_none(curve):
    assert not spikes(curve, MIN_ROTATION)


def amc(text: str, bone: str, more) -> str:
    """Return an AMC file with a channel of a bone changed in its 90th frame."""
    lines, frame = text.splitlines(), 0
    for k, line in enumerate(lines):
        frame = int(line) if line.strip().isdigit() else frame
        if frame == 90 and line.split()[0] == bone:
            first, *rest = line.split()[1:]
            lines[k] = " ".join([bone, f"{float(first) + more:.6f}", *rest])
    return "\n".join(lines) + "\n"


def bvh(text: str, joint: str, more: float) -> str:
    """Return a BVH file with a channel changed in its 90th frame: x of the root, or a turn."""
    head, _, rows = text.partition("Frame Time:")
    column, lines = 0, rows.splitlines()
    name = ""
    for line in head.splitlines():
        words = line.split()
        if words[:1] in (["ROOT"], ["JOINT"]):
            name = words[1]
        elif words[:1] == ["CHANNELS"]:
            if name.lower() == joint.lower():
                column += [w[:9] for w in words[2:]].index(
                    "Xposition" if not column else "Xrotation"
                )
                break
            column += int(words[1])
    values = lines[90].split()
    values[column] = f"{float(values[column]) + more:.6f}"
    lines[90] = " ".join(values)
    return head + "Frame Time:" + "\n".join(lines) + "\n"


# Of a file: what writes a fault into it, the toe and the root, and what 0.3 m is in its unit.
FILES = {
    "cmu_asfamc/02_03.amc": (amc, "rtoes", "root", 0.3 / 0.0564),
    "cmu_bvh/13_11.bvh": (bvh, "rFoot", "hip", 30.0),
}


def faulty(data, tmp_path, name, fault):
    """Return the path of a good file and of a copy with a fault, each in a folder of its own."""
    change, toe, root, far = FILES[name]
    path = data / name
    for other in path.parent.glob("*.asf"):
        (tmp_path / other.name).write_bytes(other.read_bytes())
    copy = tmp_path / path.name
    where, more = (toe, 90.0) if fault == "toe" else (root, far)
    copy.write_text(change(path.read_text(), where, more))
    return path, copy


@pytest.mark.parametrize("fault", ["toe", "root"])
@pytest.mark.parametrize("name", FILES)
def test_a_glitch_in_a_skeleton_file_is_bridged(data, tmp_path, name, fault):
    path, copy = faulty(data, tmp_path, name, fault)
    good, bad = read(path).skeleton, read(copy).skeleton
    mended, found = without_spikes(bad, range(len(bad.names)))
    assert len(without_spikes(good, range(len(good.names)))[1]) + 1 == len(found)
    leap = found[0]
    assert np.rad2deg(leap.angle) == pytest.approx(90, abs=5) or leap.distance == pytest.approx(
        0.3, rel=0.05
    )
    assert np.abs(mended.positions - good.positions).max() < 0.01
    assert np.nanmax(np.abs(mended.ends - good.ends)) < 0.01
    assert np.nanmax(np.abs(bad.ends - good.ends)) > 0.04


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["toe", "root"])
@pytest.mark.parametrize("name", FILES)
def test_a_glitch_in_a_skeleton_file_takes_no_forces(data, tmp_path, name, fault):
    (_, good), (_, bad) = (fit_trial(p) for p in faulty(data, tmp_path, name, fault))
    said = [note for note in bad.notes if "far off the curve" in note]
    assert said and ("°" in said[0] if fault == "toe" else "30 cm" in said[0])
    assert (good.ground is None) == (bad.ground is None)
    if good.ground is not None:
        off = good.ground.forces.force - bad.ground.forces.force
        weight = 9.81 * good.fit.human.mass
        assert np.sqrt(np.mean(off**2)) < 0.01 * weight


def test_a_glitch_in_a_coordinate_is_bridged_with_a_note(data):
    recording = read(data / "opensim" / "opencap_subject4" / "squats1_ik.mot")
    table = recording.coordinates
    column = table.names.index("knee_angle_r")
    table.values[300, column] += 0.5
    fit = fit_coordinates(recording)
    assert any("knee_angle_r by 29°" in note for note in fit.warnings)
