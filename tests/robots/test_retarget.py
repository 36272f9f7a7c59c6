"""A person's walk on robots: feet that stand, joints within their ranges, files for others."""

import json
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np
import pytest

import plantigrade as pg
from benchmarks.robots import WHEEL_ROBOTS
from plantigrade.commands import main as cli
from plantigrade.contact.ground import Ground
from plantigrade.errors import FileError, FitError, ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.robots import RetargetSettings, Robot, RobotSettings, retarget
from tests.robots.biped import biped
from tests.textbook import walk_record

SETTINGS = RetargetSettings(rate=25.0)


@pytest.fixture(scope="module")
def walk() -> Record:
    """A stride of the textbook walk."""
    return walk_record(Human.create(1.75, 73.0), speed=1.2, rate=60.0, cycles=1)


@pytest.fixture(scope="module")
def robot(tmp_path_factory) -> Robot:
    path = tmp_path_factory.mktemp("robot") / "biped.xml"
    path.write_text(biped())
    return Robot.load(path)


@pytest.fixture(scope="module")
def walked(walk, robot):
    return retarget(walk, robot, SETTINGS)


def test_feet_stand_and_joints_stay_within_their_ranges(walked):
    assert walked.status == "ok", walked.figures
    assert walked.figures["slip_max_mm"] < 1.0
    assert walked.figures["depth_max_mm"] < 0.5
    model, qpos = walked.robot.model, walked.qpos[:, 7:]
    low, high = model.jnt_range[1:].T
    assert (qpos >= low).all() and (qpos <= high).all()
    assert walked.figures["self_contact_max_mm"] < 1.0


def test_it_walks_as_the_person_does(walked, walk):
    """Hips go as far as scale says, and knees bend as much."""
    scale = walked.targets.scale
    gone = walk.motion.qpos[-1, 0] - walk.motion.qpos[0, 0]
    assert walked.qpos[-1, 0] - walked.qpos[0, 0] == pytest.approx(scale * gone, abs=0.05)
    assert walked.figures["hip_error_mm"] < 30
    knee = np.degrees(walked.qpos[:, 7 + walked.robot.hinges.index("left_knee")])
    theirs = np.degrees(walk.motion["knee_angle_l"])
    assert knee.max() == pytest.approx(theirs.max(), abs=12)


def test_one_weighted_problem_lets_feet_sink(walk, robot, walked):
    """The check can fail: without the order the feet give way to the rest."""
    other = retarget(walk, robot, SETTINGS, ordered=False)
    assert other.figures["depth_max_mm"] > 1.0
    assert "below the ground" in other.status


@pytest.mark.parametrize("options", [{"facing": 90.0}, {"free": False}, {"arms": False}])
def test_any_stance_of_the_model_will_do(options, walk, tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(biped(**options))
    motion = retarget(walk, path, SETTINGS)
    assert motion.status == "ok", motion.figures
    assert motion.qpos[-1, 0] - motion.qpos[0, 0] > 0.5


def test_arms_are_held_away_from_wide_hips(walk, walked, tmp_path):
    path = tmp_path / "wide.xml"
    path.write_text(biped(hips=0.22))
    wide = retarget(walk, path, SETTINGS)
    assert wide.figures["arm_abduction_deg"] > walked.figures["arm_abduction_deg"]
    assert wide.figures["self_contact_max_mm"] < 1.0


def test_files_hold_the_motion(walked, tmp_path):
    folder = walked.save(tmp_path / "out")
    mjlab = np.load(folder / "motion.npz")
    n, bodies = len(walked.qpos), walked.robot.model.nbody - 1
    assert mjlab["joint_pos"].shape == mjlab["joint_vel"].shape == (n, len(walked.robot.hinges))
    assert mjlab["body_pos_w"].shape == (n, bodies, 3)
    assert mjlab["body_quat_w"].shape == (n, bodies, 4)
    assert mjlab["fps"] == 25
    table = np.loadtxt(folder / "motion.csv", delimiter=",")
    assert table[:, :3] == pytest.approx(walked.qpos[:, :3], abs=1e-5)
    assert table[:, [6, 3, 4, 5]] == pytest.approx(walked.qpos[:, 3:7], abs=1e-5)
    loco = np.load(folder / "trajectory.npz")
    assert loco["qpos"] == pytest.approx(walked.qpos)
    assert list(loco["joint_names"][1:]) == list(walked.robot.hinges)
    assert loco["xpos"].shape == (n, bodies + 1, 3)


def test_velocities_are_those_of_the_poses(walked):
    """MuJoCo moves by them from one frame to where the next but one is half way."""
    model, k = walked.robot.model, 10
    pose = walked.qpos[k].copy()
    mujoco.mj_integratePos(model, pose, walked.qvel[k], 1 / 25)
    halfway = (walked.qpos[k + 1] - walked.qpos[k - 1]) / 2 + walked.qpos[k]
    assert pose == pytest.approx(halfway, abs=0.02)
    moved = np.gradient(walked.bodies["position"], 1 / 25, axis=0)
    assert walked.bodies["velocity"][5:-5] == pytest.approx(moved[5:-5], abs=0.25)


def test_velocities_of_bodies_are_those_of_mujoco(walked):
    model, k = walked.robot.model, 10
    data, twist = mujoco.MjData(model), np.zeros(6)
    data.qpos, data.qvel = walked.qpos[k], walked.qvel[k]
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    for body in range(1, model.nbody):
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, twist, 0)
        assert walked.bodies["angular_velocity"][k, body - 1] == pytest.approx(twist[:3], abs=1e-9)
        assert walked.bodies["velocity"][k, body - 1] == pytest.approx(twist[3:], abs=1e-9)


def test_names_say_which_body_is_which(walk, tmp_path):
    path = tmp_path / "robot.xml"
    text = biped(arms=False)
    for n, word in enumerate(("hip_yaw", "hip_roll", "hip_pitch", "knee")):
        text = text.replace(f"{word}_link", f"part{n}_link")
    path.write_text(text)
    names = {f"hip_{s[0]}": f"{s}_part0_link" for s in ("left", "right")}
    names |= {f"knee_{s[0]}": f"{s}_part3_link" for s in ("left", "right")}
    names |= {f"ankle_{s[0]}": f"{s}_ankle_pitch_link" for s in ("left", "right")}
    assert retarget(walk, Robot.load(path, names), SETTINGS).figures["slip_max_mm"] < 2


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("<mujoco/>", (ParameterError, FileError), "robot"),
        ("no xml", FileError, "MuJoCo cannot read"),
        (
            '<mujoco><worldbody><body name="a"><freejoint/><geom size=".1"/></body></worldbody>'
            "</mujoco>",
            FitError,
            "cannot be identified",
        ),
        (
            '<mujoco><worldbody><body name="a"><freejoint/><geom size=".1"/><body name="b">'
            '<joint type="ball"/><geom size=".1"/></body></body></worldbody></mujoco>',
            ParameterError,
            "hinges alone",
        ),
    ],
)
def test_what_is_no_robot_is_refused(text, error, words, tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(text)
    with pytest.raises(error, match=words):
        Robot.load(path)


@pytest.mark.parametrize(
    ("old", "new", "error", "words"),
    [
        ('pos="0 0 -0.35"', 'pos="0 0 nan"', FileError, "holds NaN"),
        ('range="-2 1.5"', 'range="nan 1.5"', FileError, "holds NaN"),
        ('pos="0 0 -0.35"', 'pos="0 0 -1e300"', ParameterError, "legs of the robot"),
        ('pos="0.04 0 -0.04"', 'pos="0.04 0 -1e300"', ParameterError, "legs of the robot"),
    ],
)
def test_numbers_of_no_robot_are_refused(old, new, error, words, tmp_path, monkeypatch):
    """In one sentence, without warnings of NumPy or a log file of MuJoCo."""
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(biped(arms=False).replace(old, new))
    with np.errstate(all="raise"), pytest.raises(error, match=words):
        Robot.load("robot.xml")
    assert [p.name for p in tmp_path.iterdir()] == ["robot.xml"]


def test_a_larger_robot_can_be_allowed(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(biped(arms=False))
    with pytest.raises(ParameterError, match="legs of the robot"):
        Robot.load(path, settings=RobotSettings(leg_lengths=(1.0, 5.0)))


def test_a_motion_shorter_than_two_frames_is_refused(walk, robot):
    short = Motion(walk.motion.time[:3], walk.motion.qpos[:3], walk.motion.qvel[:3],
                   walk.motion.joint_names)  # fmt: skip
    with pytest.raises(ParameterError, match="two frames"):
        retarget(Record(walk.human, short), robot, SETTINGS)


def test_other_ground_and_unknown_names_are_refused(walk, robot, tmp_path):
    slope = Record(walk.human, walk.motion, ground=Ground(slope=0.1))
    with pytest.raises(ParameterError, match="level ground"):
        retarget(slope, robot)
    (tmp_path / "robot.xml").write_text(biped())
    for names, words in (({"hip_l": "leg"}, "no body 'leg'"), ({"hop_l": "base"}, "no joint")):
        with pytest.raises(ParameterError, match=words):
            Robot.load(tmp_path / "robot.xml", names)
    with pytest.raises(FileError, match="no such file"):
        Robot.load(tmp_path / "none.xml")


@pytest.mark.slow
@pytest.mark.parametrize("package", sorted(WHEEL_ROBOTS))
def test_robots_that_packages_carry(package, walk):
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        pytest.skip(f"{package} is not installed")
    motion = pg.retarget(walk, Path(spec.origin).parent / WHEEL_ROBOTS[package], SETTINGS)
    assert motion.status == "ok", motion.figures
    assert motion.figures["self_contact_max_mm"] < 2
    assert motion.figures["limb_error_deg"] < 8


def test_the_command_writes_a_folder(walk, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pg.Run(walk, "fit", name="walk").save("walk")
    Path("robot.xml").write_text(biped(arms=False))
    assert cli.main(["retarget", "walk", "--to", "robot.xml", "--rate", "20", "--quiet"]) == 0
    assert "check passed" in capsys.readouterr().out
    folder = Path("runs/retarget-walk-robot")
    assert {p.name for p in folder.iterdir()} == {
        "metrics.json", "motion.npz", "motion.csv", "trajectory.npz",
    }  # fmt: skip
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["status"] == "ok" and metrics["bodies"]["knee_l"] == "left_knee_link"
    assert "robot.xml" in metrics["source_files"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["walk.bvh", "--to", "robot.xml"], "plantigrade fit"),
        (["walk"], "--to robot.xml"),
        (["walk", "--to", "none.xml"], "there is no such file"),
        (["walk", "--to", "robot.xml", "--names", "names.toml"], "no joint of a person"),
        (["walk", "--to", "robot.xml", "--rate", "0"], "rate"),
    ],
)
def test_what_the_command_refuses(words, said, walk, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pg.Run(walk, "fit", name="walk").save("walk")
    Path("robot.xml").write_text(biped())
    Path("walk.bvh").write_text("HIERARCHY")
    Path("names.toml").write_text('hop_l = "base"')
    assert cli.main(["retarget", *words]) == 2
    assert said in capsys.readouterr().err
    assert not Path("runs").exists()
