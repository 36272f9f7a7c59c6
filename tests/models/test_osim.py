"""The person as an OpenSim model."""

from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest

from plantigrade.models import JOINT_SETS, Human
from plantigrade.models.markers import MARKER_SETS, places_of
from plantigrade.models.osim import to_osim
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD


@pytest.mark.parametrize("joints", JOINT_SETS)
def test_the_model_has_the_coordinates_of_mot_files_and_the_mass(joints):
    human = Human.create(joints=joints)
    model = ET.fromstring(to_osim(human).encode()).find("Model")
    coordinates = {c.get("name"): c for c in model.iter("Coordinate")}
    names, standing = human.to_coordinates(human.standing()[None])
    assert tuple(coordinates) == names
    values = [float(c.findtext("default_value")) for c in coordinates.values()]
    assert values == pytest.approx(standing[0])
    low, high = zip(
        *(coordinates[n].findtext("range").split() for n in human.coordinates), strict=False
    )
    assert np.array([low, high], dtype=float) == pytest.approx(human.limits)
    assert sum(float(m.text) for m in model.iter("mass")) == pytest.approx(human.mass)


@pytest.mark.slow
@pytest.mark.parametrize("joints", JOINT_SETS)
def test_opensim_puts_bodies_markers_and_mass_where_mujoco_does(joints, tmp_path):
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("off")
    human = Human.create(1.65, 60.0, joints=joints)
    markers = places_of(MARKER_SETS["rajagopal"], human)
    path = tmp_path / "person.osim"
    path.write_text(to_osim(human, markers), encoding="utf-8")
    model = opensim.Model(str(path))
    state = model.initSystem()
    data = mujoco.MjData(human.model)
    rng = np.random.default_rng(0)
    for _ in range(3):
        qpos = human.standing()
        qpos[:7] = rng.normal(size=7)
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        qpos[7:] = rng.uniform(*human.limits)
        names, values = human.to_coordinates(qpos[None])
        for name, value in zip(names, values[0], strict=True):
            model.getCoordinateSet().get(name).setValue(state, float(value), False)
        model.realizePosition(state)
        data.qpos = qpos
        mujoco.mj_forward(human.model, data)
        found = [
            model.getBodySet().get(name).getPositionInGround(state) for name in human.body_names
        ]
        found += [model.getMarkerSet().get(n).getLocationInGround(state) for n in markers]
        found += [model.calcMassCenterPosition(state)]
        there = [data.body(name).xpos for name in human.body_names]
        there += [
            data.body(p.body).xpos + data.body(p.body).xmat.reshape(3, 3) @ p.position
            for p in markers.values()
        ]
        there += [data.subtree_com[1]]
        assert np.array([OPENSIM_TO_WORLD @ f.to_numpy() for f in found]) == pytest.approx(
            np.array(there), abs=1e-9
        )
