"""The command that shows and writes a person."""

import json

import mujoco
import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.models import Human
from plantigrade.models.markers import MARKER_SETS


def run(capsys, *words):
    code = cli.main(["model", *words])
    return code, *capsys.readouterr()


def test_the_summary_names_what_the_person_is_made_of(capsys):
    code, out, _ = run(capsys, "--height", "1.5", "--mass", "48.5", "--joints", "66")
    assert code == 0
    assert "66 coordinates" in out and "21 segments" in out
    for word in ("hip_flexion_r", "femur_r", "thigh", "multi-segment"):
        assert word in out


def test_json_holds_counts_masses_lengths_ranges_and_strengths(capsys):
    code, out, _ = run(capsys, "--json", "--sex", "female", "--mass", "60")
    found = json.loads(out)
    assert code == 0 and found["status"] == "ok"
    human = Human.create(mass=60.0, sex="female")
    assert found["coordinate_count"] == human.model.nv == 42
    assert found["segment_count"] == 19
    assert found["mass_kg"] == pytest.approx(60.0)
    total = sum(row["mass_kg"] for row in found["segments"].values())
    assert total == pytest.approx(60.0)
    assert found["lengths_m"]["thigh"] == human.dimensions.thigh
    knee = found["coordinates"]["knee_angle_r"]
    low, high = np.rad2deg(human.limits[:, human.hinge("knee_angle_r")])
    assert (knee["low_deg"], knee["high_deg"]) == pytest.approx((low, high))
    assert knee["weakest_nm"] < 0 < knee["strongest_nm"]
    assert "Anderson 2007" in knee["strength_source"]
    assert list(found["coordinates"]) == list(human.coordinates)


def test_the_file_is_the_persons_model(capsys, tmp_path):
    path = tmp_path / "new" / "person.xml"
    code, out, _ = run(capsys, "--out", str(path), "--feet", "rigid", "--lengths", "thigh=0.43")
    assert code == 0 and f"wrote {path}" in out
    human = Human.create(feet="rigid", lengths={"thigh": 0.43})
    model = mujoco.MjModel.from_xml_path(str(path))
    np.testing.assert_array_equal(model.body_pos, human.model.body_pos)
    code, _, err = run(capsys, "--out", str(path))
    assert code == 2 and "--overwrite" in err
    assert run(capsys, "--out", str(path), "--overwrite")[0] == 0
    assert [p.name for p in path.parent.iterdir()] == ["person.xml"]


def test_an_opensim_model_has_the_markers_and_no_actuators(capsys, tmp_path):
    path = tmp_path / "person.osim"
    assert run(capsys, "--marker-set", "plug-in-gait", "--out", str(path))[0] == 0
    assert '<Marker name="LASI">' in path.read_text(encoding="utf-8")
    code, _, err = run(capsys, "--out", str(path), "--overwrite", "--actuators", "torque")
    assert code == 2 and "--actuators" in err


def test_a_dash_prints_the_model_alone(capsys):
    code, out, _ = run(capsys, "--out", "-")
    assert code == 0
    assert mujoco.MjModel.from_xml_string(out).nv == 42


def test_lengths_may_come_several_times(capsys):
    _, out, _ = run(capsys, "--json", "--lengths", "thigh=0.43", "--lengths", "shank=0.41")
    found = json.loads(out)["lengths_m"]
    assert (found["thigh"], found["shank"]) == (0.43, 0.41)


@pytest.mark.parametrize("name", MARKER_SETS)
def test_markers_are_sites(capsys, tmp_path, name):
    path = tmp_path / "person.xml"
    code, _, _ = run(capsys, "--marker-set", name, "--out", str(path))
    assert code == 0
    model = mujoco.MjModel.from_xml_path(str(path))
    sites = {model.site(i).name for i in range(model.nsite)}
    assert sites == set(MARKER_SETS[name].landmarks)
    assert model.nv == 42 and model.body_mass.sum() == pytest.approx(71.0)


def test_an_own_marker_set(capsys, tmp_path):
    own = tmp_path / "lab.toml"
    own.write_text('[markers]\nRTH = { body = "femur_r", position = [0.05, -0.09, -0.2] }\n')
    code, out, _ = run(capsys, "--marker-set", str(own), "--json")
    assert code == 0
    assert json.loads(out)["markers"] == {
        "RTH": {"body": "femur_r", "position_m": [0.05, -0.09, -0.2]}
    }


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--lengths", "thigh"), "write NAME=METRES"),
        (("--lengths", "thigh=long"), "write NAME=METRES"),
        (("--lengths", "tail=0.3"), "unknown segment length 'tail'; allowed are"),
        (("--lengths", "thigh=0.4", "--lengths", "thigh=0.5"), "given twice"),
        (("--lengths", "thigh=nan"), "thigh is nan m; allowed is 0.01 to 1 m"),
        (("--height", "17.4"), "height must be 0.5–2.5 m for a person, not 17.4"),
        (("--marker-set", "mine"), "allowed are plug-in-gait"),
        (("--marker-set", "absent.toml"), "absent.toml: cannot be read"),
    ],
)
def test_bad_input_is_one_sentence(capsys, words, message):
    code, out, err = run(capsys, *words)
    assert code == 2 and not out
    assert message in err and err.count("\n") == 1


def test_a_model_with_actuators_is_written_whole(tmp_path, capsys):
    out = tmp_path / "robot.xml"
    words = ["model", "--out", str(out), "--sensors", "feet", "--foot-stiffness", "2e5"]
    assert cli.main([*words]) == 2
    assert "--sensors needs --actuators" in capsys.readouterr().err and not out.exists()
    assert cli.main([*words, "--actuators", "position"]) == 0
    model = mujoco.MjModel.from_xml_path(str(out))
    assert model.nu == model.nv - 6 and model.nsensor == 2
    assert np.array_equal(model.key_ctrl[0], model.key_qpos[0][7:])
