"""``plantigrade fit`` as a user calls it, and what it leaves checked without our code."""

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.errors import ParameterError
from plantigrade.record.inputs import inputs, names_of
from tests.browser import wait_for
from tests.textbook import walk_file

KINDS = {
    "HC038A11": ("c3d/HC038A11.c3d", ["HC038A01.c3d"]),
    "markers_walk": ("opensim/rajagopal_walk/markers_walk.trc", ["grf_walk.mot"]),
    "16_15": ("cmu_asfamc/16_15.amc", ["16.asf"]),
    "07_01": ("cmu_bvh/07_01.bvh", []),
    "humanoid3d_walk": ("deepmimic/humanoid3d_walk.txt", []),
    "normal_gait": ("opensim/gait2392_subject01/normal_gait.mot", []),
}
MEASURED = ("HC038A11", "markers_walk")
FILES = {"model.xml", "motion.npz", "motion.mot", "metrics.json", "report.html", "viewer.html"}


def plantigrade(*words, cwd: Path, **options) -> subprocess.CompletedProcess:
    """Run the command line in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "plantigrade", *map(str, words)],
        capture_output=True, text=True, cwd=cwd, **options,
    )  # fmt: skip


def batch_of(study) -> Path:
    """Return the folder of the batch."""
    (folder,) = (study[1] / "runs").iterdir()
    return folder


@pytest.fixture(scope="module")
def study(data, tmp_path_factory):
    """One call over a recording of each kind and a broken one: its process and its folder."""
    folder = tmp_path_factory.mktemp("study")
    broken = folder / "broken.trc"
    broken.write_text("PathFileType\t4\t(X/Y/Z)\tbroken.trc\nno markers here\n")
    files = [data / path for path, _ in KINDS.values()]
    files.insert(2, broken)
    return plantigrade("fit", *files, "--jobs", "2", "--json", cwd=folder), folder


def test_one_bad_file_among_good_ones(study):
    done, folder = study
    assert done.returncode == 3, done.stderr
    (batch,) = (folder / "runs").iterdir()
    assert batch.name.startswith("fit-batch-") and batch.name.endswith("-and-6-more")
    assert {p.name for p in batch.iterdir() if p.is_dir()} == set(KINDS)
    with (batch / "batch.csv").open(encoding="utf-8") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}
    assert list(rows) == [*list(KINDS)[:2], "broken", *list(KINDS)[2:]]
    assert "broken.trc" in rows["broken"]["status"] and "broken.trc" in done.stderr
    assert (batch / "failed.txt").read_text("utf-8") == f"{folder / 'broken.trc'}\n"
    metrics = json.loads(done.stdout)
    assert metrics["status"] == "1 of 7 recordings failed"
    assert metrics == json.loads((batch / "metrics.json").read_text("utf-8"))
    for name in KINDS:
        own = json.loads((batch / name / "metrics.json").read_text("utf-8"))
        assert rows[name]["status"] == own["status"]
        assert float(rows[name]["height_m"]) == pytest.approx(own["height_m"], rel=1e-5)
        assert rows[name]["sha256"] == own["source_files"][Path(rows[name]["file"]).name]


@pytest.mark.parametrize("name", KINDS)
def test_the_run_folder_is_whole(study, data, name):
    folder = batch_of(study) / name
    metrics = json.loads((folder / "metrics.json").read_text())
    strides = metrics.get("strides_r_count", 0) + metrics.get("strides_l_count", 0)
    walks = {"curves.csv"} if strides else set()
    assert {p.name for p in folder.iterdir()} == FILES | walks
    assert metrics["status"] == "ok" and metrics["seed"] is None
    assert metrics["command"].startswith("plantigrade fit ")
    path, companions = KINDS[name]
    files = [data / path, *((data / path).parent / c for c in companions)]
    sums = {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in files}
    assert metrics["source_files"] == sums
    for page in ("report.html", "viewer.html"):
        assert len((folder / page).read_text(encoding="utf-8")) > 20_000


@pytest.mark.parametrize("name", KINDS)
def test_the_model_loads_and_moves_in_plain_mujoco(study, name):
    folder = batch_of(study) / name
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    run = np.load(folder / "motion.npz")
    metrics = json.loads((folder / "metrics.json").read_text())
    n = len(run["time"])
    assert run["qpos"].shape == (n, model.nq)
    assert run["qvel"].shape == run["qacc"].shape == (n, model.nv)
    assert [str(j) for j in run["joint_names"]] == [model.joint(i).name for i in range(model.njnt)]
    assert (np.diff(run["time"]) > 0).all() and np.isfinite(run["qpos"]).all()
    np.testing.assert_allclose(np.linalg.norm(run["qpos"][:, 3:7], axis=1), 1, atol=1e-9)
    assert model.body_mass.sum() == pytest.approx(metrics["mass_kg"], rel=1e-6)
    assert n == metrics["frames"]
    # Velocities are the rate of the configurations (differences over two frames).
    middle = np.empty((n - 2, model.nv))
    for f in range(1, n - 1):
        dt = run["time"][f + 1] - run["time"][f - 1]
        mujoco.mj_differentiatePos(model, middle[f - 1], dt, run["qpos"][f - 1], run["qpos"][f + 1])
    off = np.sqrt(np.mean((middle - run["qvel"][1:-1]) ** 2))
    assert off < 0.1 * np.sqrt(np.mean(run["qvel"] ** 2))


@pytest.mark.parametrize("name", MEASURED)
def test_moments_can_be_checked_without_our_code(study, name):
    """Inverse dynamics less the wrenches on the segments named is what the run says."""
    folder = batch_of(study) / name
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(model)
    run = np.load(folder / "motion.npz")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_DAMPER
    model.dof_armature[:] = 0.0
    bodies = [model.body(str(segment)).id for segment in run["contact_segment"]]
    assert (np.abs(run["contact_force"]).max(axis=(0, 1)) > 10).all()
    for f in range(len(run["time"])):
        data.qpos[:], data.qvel[:], data.qacc[:] = (run[k][f] for k in ("qpos", "qvel", "qacc"))
        mujoco.mj_inverse(model, data)
        ground = np.zeros(model.nv)
        for k, body in enumerate(bodies):
            if run["contact_force"][f, k].any():
                mujoco.mj_applyFT(
                    model, data, run["contact_force"][f, k], run["contact_torque"][f, k],
                    run["contact_point"][f, k], body, ground,
                )  # fmt: skip
        np.testing.assert_allclose(data.qfrc_inverse - ground, run["qfrc_actuator"][f], atol=1e-6)


def read_mot(path: Path) -> tuple[list[str], np.ndarray]:
    """Return names and numbers of a MOT file in degrees."""
    lines = path.read_text().splitlines()
    end = lines.index("endheader")
    assert "inDegrees=yes" in lines[:end]
    return lines[end + 1].split("\t"), np.array([x.split("\t") for x in lines[end + 2 :]], float)


@pytest.mark.parametrize("name", KINDS)
def test_the_mot_file_is_the_same_motion(study, name):
    folder = batch_of(study) / name
    names, rows = read_mot(folder / "motion.mot")
    run = np.load(folder / "motion.npz")
    np.testing.assert_allclose(rows[:, 0], run["time"], atol=1e-6)
    for i, joint in enumerate(run["joint_names"][1:], start=7):
        column = np.deg2rad(rows[:, names.index(str(joint))])
        np.testing.assert_allclose(column, run["qpos"][:, i], atol=1e-5, err_msg=str(joint))
    # OpenSim's axes: x forward, y up, z to the right
    pelvis = rows[:, [names.index(f"pelvis_t{a}") for a in "xyz"]]
    np.testing.assert_allclose(pelvis, run["qpos"][:, [0, 2, 1]] * [1, 1, -1], atol=1e-5)


@pytest.mark.parametrize("name", ["HC038A11", "markers_walk"])
def test_markers_lie_where_the_body_has_them(study, name):
    """The mean error the run states, computed anew from its own recorded and fitted markers."""
    folder = batch_of(study) / name
    metrics = json.loads((folder / "metrics.json").read_text())
    run = np.load(folder / "motion.npz")
    off = np.linalg.norm(run["recorded_markers"] - run["fitted_markers"], axis=2)
    rms = 1e3 * np.sqrt(np.nanmean(off**2, axis=1)).mean()
    assert rms == pytest.approx(metrics["marker_rms_mean_mm"], rel=0.15)  # filtered afterwards
    assert rms < 10


@pytest.mark.parametrize("name", MEASURED)
def test_plantigrade_report_writes_the_same_pages(study, name):
    folder = batch_of(study) / name
    before = {p: (folder / p).read_text(encoding="utf-8") for p in ("report.html", "viewer.html")}
    done = plantigrade("report", folder, cwd=study[1])
    assert done.returncode == 0, done.stderr
    assert {p.name for p in folder.iterdir()} >= FILES
    for page, text in before.items():
        assert (folder / page).read_text(encoding="utf-8") == text, page


def test_an_existing_folder_is_refused_before_any_work(tmp_path, monkeypatch, capsys):
    from plantigrade.workflows import fit as fitting

    monkeypatch.setattr(fitting, "load", lambda *_: pytest.fail("work was done"))
    monkeypatch.chdir(tmp_path)
    for name in ("walk.c3d", "other.c3d"):
        (tmp_path / name).touch()
    (tmp_path / "runs" / "fit-walk").mkdir(parents=True)
    (tmp_path / "runs" / "fit-walk" / "metrics.json").write_text("{}")
    assert cli.main(["fit", "walk.c3d", "--out", "runs/fit-walk"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    # without --out a batch would be numbered, but not where it is to be replaced
    (tmp_path / "runs" / "fit-batch-other-and-1-more").mkdir()
    (tmp_path / "runs" / "fit-batch-other-and-1-more" / "metrics.json").write_text("{}")
    assert cli.main(["fit", "other.c3d", "walk.c3d", "--overwrite"]) == 2
    assert "does not mark a run" in capsys.readouterr().err
    # what is no run folder is never replaced
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    assert cli.main(["fit", "walk.c3d", "--out", "mine", "--overwrite"]) == 2
    assert "not a run folder" in capsys.readouterr().err
    assert (tmp_path / "mine" / "thesis.tex").exists()


def test_files_of_one_name_go_to_folders_of_their_own():
    names = names_of([Path("a/07_01.amc"), Path("b/07_01.bvh"), Path("16_15.amc")])
    assert names == ["07_01-amc", "07_01-bvh", "16_15"]
    names = names_of([Path("day1/walk.c3d"), Path("day2/walk.c3d"), Path("day2/walk.trc")])
    assert names == ["day1-walk-c3d", "day2-walk-c3d", "walk-trc"]
    names = names_of([Path("p1/day1/walk.c3d"), Path("p2/day1/walk.c3d")])
    assert len(set(names)) == 2
    with pytest.raises(ParameterError, match="twice"):
        inputs([Path("walk.c3d"), Path("./walk.c3d")], fits=Path.is_file)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["fit", "{data}/opensim/gait2392_subject01/subject01_walk1_grf.mot"], "no motion to fit"),
        (["fit", "nowhere.c3d"], "nowhere.c3d"),
        (
            ["fit", "{data}/c3d/HC038A11.c3d", "--norms", "nowhere.csv"],
            "nowhere.csv: there is no such file",
        ),
        (["fit", "a.c3d", "--age", "200"], "age must be 0.5–120 years"),
        (
            ["fit", "{data}/c3d/HC038A11.c3d", "--static", "{data}/cmu_asfamc/07_01.amc"],
            "not a standing trial",
        ),
        (
            ["fit", "{data}/cmu_asfamc/07_01.amc", "--forces", "{data}/cmu_asfamc/07_05.amc"],
            "holds no ground reactions",
        ),
        (["fit", "{data}/c3d/HC038A11.c3d", "--skeleton", "{data}/cmu_asfamc/07.asf"], "skeleton"),
    ],
)
def test_bad_input_is_one_sentence(data, tmp_path, monkeypatch, capsys, words, sentence):
    monkeypatch.chdir(tmp_path)
    assert cli.main([w.replace("{data}", str(data)) for w in words]) == 2
    out, err = capsys.readouterr()
    assert sentence in err and "Traceback" not in err and not out
    assert not (tmp_path / "runs").exists()


def test_a_named_file_of_forces_comes_before_those_in_the_recording(data, tmp_path):
    from plantigrade.io import read, write
    from plantigrade.motion import Recording
    from plantigrade.workflows.fit import load
    from plantigrade.workflows.settings import FitSettings

    own = read(data / "c3d/HC038A11.c3d")
    other = tmp_path / "mine.mot"
    write(Recording(other, plates=own.plates[:1]), other)
    loaded = load(data / "c3d/HC038A11.c3d", FitSettings(forces=other))
    assert len(loaded.plates) == 1 and len(own.plates) == 2
    assert other in loaded.companions


def test_an_interrupted_run_leaves_nothing(data, tmp_path, monkeypatch, capsys):
    from plantigrade.record import folder as run_folder

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(run_folder, "_put_in_next_place", interrupt)  # all is written but the name
    monkeypatch.chdir(tmp_path)
    assert cli.main(["fit", str(data / KINDS["normal_gait"][0])]) == 130
    assert "no incomplete run folder" in capsys.readouterr().err
    assert list((tmp_path / "runs").iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_control_c_on_several_files(data, tmp_path, sent, code):
    names = ("humanoid3d_walk", "07_01", "16_15")
    files = [data / KINDS[name][0] for name in names]
    process = subprocess.Popen(
        [sys.executable, "-m", "plantigrade", "fit", *map(str, files), "--jobs", "2"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
        # the signal is ignored where the tests are a job in the background
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert process.stderr is not None and process.stderr.readline(), "the first is done"
    if sent == signal.SIGINT:
        os.killpg(process.pid, sent)  # as a terminal sends it: to the workers too
    else:
        process.send_signal(sent)  # as a batch system sends it
    _, err = process.communicate()
    assert process.returncode == code, err
    left = list((tmp_path / "runs").iterdir()) if (tmp_path / "runs").exists() else []
    (batch,) = left
    made = [folder for folder in batch.iterdir() if folder.is_dir()]
    assert all({p.name for p in folder.iterdir()} >= FILES for folder in made)
    assert not [path for path in (*left, *made) if path.name.startswith(".")]
    if sent == signal.SIGTERM:  # the same command goes on after either
        again = plantigrade("fit", *files, "--jobs", "2", cwd=tmp_path)
        assert again.returncode == 0 and " of 3 were there" in again.stderr
        assert [path.name for path in (tmp_path / "runs").iterdir()] == [batch.name]
    said = "interrupted" if sent == signal.SIGINT else "terminated"
    assert said in err.splitlines()[-1]
    wait_for(lambda: not in_group(process.pid))  # no worker is left


def in_group(group: int) -> bool:
    """Return whether a process of a group is alive."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A textbook walk in an empty folder."""
    return walk_file(tmp_path_factory.mktemp("walks") / "walk.c3d", cycles=2)


@pytest.mark.slow
def test_run_folders_are_numbered(recording, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for number in ("", "-2"):
        assert cli.main(["fit", str(recording), "--quiet"]) == 0
        said = capsys.readouterr().out
        assert f"runs/fit-walk{number}: " in said
        assert f"runs/fit-walk{number}/report.html" in said
    before = (tmp_path / "runs/fit-walk/metrics.json").stat().st_mtime_ns
    assert cli.main(["fit", str(recording), "--quiet", "--overwrite"]) == 0
    assert "runs/fit-walk: " in capsys.readouterr().out
    assert (tmp_path / "runs/fit-walk/metrics.json").stat().st_mtime_ns > before
    other = tmp_path / "walk.trc"
    assert cli.main(["convert", str(recording), str(other)]) == 0
    capsys.readouterr()
    (tmp_path / "runs" / "fit-batch-walk-and-1-more").mkdir()
    (tmp_path / "runs" / "fit-batch-walk-and-1-more" / "mine").write_text("x")
    assert cli.main(["fit", str(recording), str(other), "--quiet", "--keep", "figures"]) == 0
    assert {path.name for path in (tmp_path / "runs").iterdir()} == {
        "fit-walk", "fit-walk-2", "fit-batch-walk-and-1-more", "fit-batch-walk-and-1-more-2",
    }  # fmt: skip
