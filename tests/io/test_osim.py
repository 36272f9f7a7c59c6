"""OpenSim models read as bodies on MuJoCo, against OpenSim itself and against recordings."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import read
from plantigrade.io.mot import read_table
from plantigrade.io.osim import parse_osim, read_osim
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.osim_functions import SimmSpline
from plantigrade.kinematics.state import PointSet
from plantigrade.models import JOINT_SETS, Human
from plantigrade.models.markers import MARKER_SETS, places_of
from plantigrade.models.osim import to_osim
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD
from tests.io.osim_files import every_joint

DATA = Path(__file__).parents[2] / "../shared/data/opensim"
RAJAGOPAL = DATA / "rajagopal_walk/subject_walk_scaled.osim"
MODELS = {
    "rajagopal": RAJAGOPAL,
    "opencap": DATA / "opencap_subject4/optimized_scale_and_markers.osim",
    "lai": DATA / "opencap_squat/LaiUhlrich2022.osim",
    "gait2392": DATA / "gait2392_subject01/gait2392.osim",
    "gait10dof": DATA / "gait2392_subject01/gait10dof18musc_simbody.osim",
    "planar": DATA / "moco_2d_walking/2D_gait.osim",
}
present = pytest.mark.skipif(not RAJAGOPAL.exists(), reason="needs the shared data")


def own(path: Path) -> OsimHuman:
    return OsimHuman.of(path.read_text(encoding="utf-8"), path)


@pytest.mark.parametrize("joints", JOINT_SETS)
def test_a_written_person_is_read_back_the_same(joints):
    human = Human.create(1.65, 60.0, joints=joints)
    markers = places_of(MARKER_SETS["rajagopal"], human)
    back = OsimHuman.of(to_osim(human, markers))
    assert back.mass == pytest.approx(60.0)
    qpos = np.tile(human.standing(), (5, 1))
    rng = np.random.default_rng(1)
    qpos[:, :7] = rng.normal(size=(5, 7))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    qpos[:, 7:] = rng.uniform(*human.limits, size=(5, len(human.coordinates)))
    there = PointSet.of(human, list(markers.values())).path(qpos)
    theirs = back.from_coordinates(*human.to_coordinates(qpos))
    found = PointSet.of(back, [back.places[name] for name in markers]).path(theirs)
    assert found == pytest.approx(there, abs=1e-9)
    names, values = back.to_coordinates(theirs)
    assert back.from_coordinates(names, values) == pytest.approx(theirs, abs=1e-9)


@present
def test_recorded_markers_lie_on_the_model_at_its_stored_coordinates():
    human, folder = own(MODELS["opencap"]), MODELS["opencap"].parent
    stored = read_table(folder / "squats1_ik.mot")
    markers = read(folder / "squats1.trc").markers
    names = [name for name in markers.names if name in human.places]
    qpos = human.from_coordinates(stored.names, stored.values[::10])
    points = PointSet.of(human, [human.places[n] for n in names])
    frames = [int(np.abs(markers.time - t).argmin()) for t in stored.time[::10]]
    away = np.linalg.norm(markers.select(names).positions[frames] - points.path(qpos), axis=2)
    assert len(names) > 30 and np.nanmedian(away) < 0.015


@present
def test_coupled_coordinates_are_followed_and_muscles_counted():
    osim = read_osim(RAJAGOPAL)
    assert osim.coupled == ("knee_angle_r_beta", "knee_angle_l_beta")
    assert osim.left_out["Millard2012EquilibriumMuscle"] == 80
    human = own(RAJAGOPAL)
    names, _ = human.to_coordinates(human.standing()[None])
    assert "knee_angle_r" in names and "knee_angle_r_beta" not in names
    assert human.mass == pytest.approx(85.27, abs=0.01)


def test_slopes_turn_rates_of_coordinates_into_velocities():
    human = OsimHuman.of(every_joint())
    u = np.random.default_rng(2).uniform(-0.5, 0.5, len(human.every_coordinate))
    rate, step = np.random.default_rng(3).normal(size=len(u)), 1e-6
    before, after = human.poses(np.stack([u - step * rate, u + step * rate]))
    moved = np.empty(human.model.nv)
    mujoco.mj_differentiatePos(human.model, moved, 2 * step, before, after)
    assert human.slopes(u) @ rate == pytest.approx(moved, abs=1e-7)


def test_a_description_holds_the_whole_person():
    human = OsimHuman.of(every_joint(), height=1.6, sex="female")
    again = OsimHuman.from_dict(human.to_dict())
    assert isinstance(again, OsimHuman)
    assert (again.height, again.sex, again.xml) == (1.6, "female", human.xml)
    plain = OsimHuman.from_dict(Human.create().to_dict())
    assert type(plain) is Human


def test_a_spline_passes_its_knots_and_is_straight_outside():
    x, y = np.array([0.0, 1.0, 2.5, 3.0]), np.array([1.0, -1.0, 0.5, 2.0])
    spline = SimmSpline(x, y)
    assert spline(x) == pytest.approx(y)
    out = spline(np.array([4.0, 5.0, 6.0]))
    assert out[2] - out[1] == pytest.approx(out[1] - out[0])


BROKEN = {
    "no xml": ("<OpenSimDocument", "</", "XML"),
    "other xml": ("OpenSimDocument", "Document", "not an OpenSim model"),
    "old": ('Version="40000"', 'Version="10000"', "file version"),
    "no number": ("<mass>1<", "<mass>one<", "mass of Body a"),
    "not finite": ("0.1 -0.2 0.3", "0.1 nan 0.3", "not finite"),
    "joint": ("PinJoint", "EllipsoidJoint", "EllipsoidJoint"),
    "function": ("PolynomialFunction", "Sine", "Sine"),
    "frame": ("/bodyset/f", "/bodyset/nowhere", "nowhere"),
    "loop": ("/bodyset/g</socket_child", "/bodyset/b</socket_child", "two joints"),
    "tie": ("<independent_coordinate_names>bend", "<independent_coordinate_names>p", "itself"),
    "knots": ("-1 -0.3 0.2 0.7 1.2", "-1 -0.3 0.2 0.7 0.1", "increasing"),
    "no axis": ("<scale>1</scale>", "<scale>0.5</scale>", "twist"),
    "root": ("<socket_parent_frame>/ground", "<socket_parent_frame>/bodyset/g", "ground"),
}


@pytest.mark.parametrize(("old", "new", "message"), BROKEN.values(), ids=BROKEN)
def test_what_is_damaged_or_not_read_is_named_in_one_sentence(old, new, message):
    text = every_joint()
    assert old in text
    with pytest.raises(FileError, match=message) as error:
        OsimHuman.of(text.replace(old, new), "mine.osim")
    assert "mine.osim" in str(error.value) and "\n" not in str(error.value)


def test_every_cut_of_a_file_is_refused():
    text = every_joint()
    for end in range(0, len(text) - 1, 97):
        with pytest.raises(FileError):
            parse_osim(text[:end])


def against_opensim(path: Path, human: OsimHuman, u: np.ndarray) -> tuple[float, float]:
    """Return the largest distance [m] and angle [rad] of bodies, and of markers, from OpenSim's."""
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(path))
    state = model.initSystem()
    data, W = mujoco.MjData(human.model), OPENSIM_TO_WORLD
    places, angles = [], []
    for values, qpos in zip(u, human.poses(u), strict=True):
        for c, value in zip(human.every_coordinate, values, strict=True):
            theirs = model.getCoordinateSet().get(c.name)
            theirs.setLocked(state, False)
            theirs.setValue(state, float(value), False)
        model.assemble(state)  # sets the coordinates that are tied to others
        data.qpos = qpos
        mujoco.mj_kinematics(human.model, data)
        for name in human.body_names:
            pose = model.getBodySet().get(name).getTransformInGround(state)
            R = pose.R()
            R = W @ np.array([[R.get(i, k) for k in range(3)] for i in range(3)]) @ W.T
            places.append(W @ pose.p().to_numpy() - data.body(name).xpos)
            angles.append(R - data.body(name).xmat.reshape(3, 3))
        for name, at in human.places.items():
            there = data.body(at.body).xpos + data.body(at.body).xmat.reshape(3, 3) @ at.position
            marker = model.getMarkerSet().get(name).getLocationInGround(state)
            places.append(W @ marker.to_numpy() - there)
    return float(np.abs(places).max()), float(np.abs(angles).max())


@pytest.mark.slow
@present
@pytest.mark.parametrize("name", MODELS)
def test_bodies_and_markers_are_where_opensim_puts_them(name):
    human, rng = own(MODELS[name]), np.random.default_rng(0)
    low, high = np.array([[max(c.low, -1), min(c.high, 1)] for c in human.every_coordinate]).T
    place, angle = against_opensim(MODELS[name], human, rng.uniform(low, high, (5, len(low))))
    assert place < 1e-6 and angle < 1e-6  # the stored splines hold seven digits


@pytest.mark.slow
def test_every_kind_of_joint_moves_as_in_opensim(tmp_path):
    path = tmp_path / "every.osim"
    path.write_text(every_joint(), encoding="utf-8")
    human, rng = own(path), np.random.default_rng(0)
    u = rng.uniform(-1, 1, (5, len(human.every_coordinate)))
    place, angle = against_opensim(path, human, u)
    assert place < 1e-6 and angle < 1e-6
