"""Valid files to damage: a small one of each kind, made here, and whole ones of other people.

A seed is made in an empty folder, with the files that belong to it; what is returned is the path of
the one that is damaged.
"""

import base64
import json
import pickle
import shutil
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields
from pathlib import Path

import numpy as np

import plantigrade.learn
from plantigrade.io import read
from plantigrade.io.csv import write_csv
from plantigrade.motion import ForcePlate, GaitEvent, Markers, Recording, Subject, Table
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.task_file import TaskFile

Make = Callable[[Path], Path]
"""Makes a seed in a folder, and returns the path of the file that is damaged."""
Wholes = Callable[[Path | None], Iterator[tuple[str, Make]]]
"""Lists whole files, some of them in the folder of recordings where there is one."""
POLICIES = Path(plantigrade.learn.__file__).parent / "policies"
LARGEST = 3e6
"""Largest file of other people that is damaged [bytes]: a larger one takes seconds to read."""


def recording() -> Recording:
    """Six markers, a force plate and two events, 12 frames."""
    rng = np.random.default_rng(0)
    time = 0.5 + np.arange(12) / 100
    heights = np.linspace(0.1, 1.7, 6)[:, None] * [0.1, 0.1, 1]
    positions = rng.normal(size=(12, 6, 3)) * 0.01 + heights
    plate = ForcePlate(
        "1",
        0.5 + np.arange(120) / 1000,
        np.tile([1.0, 2.0, 700.0], (120, 1)),
        np.tile([0.01, 0.02, 0.0], (120, 1)),
        np.zeros(120),
    )
    return Recording(
        Path("sample"),
        Markers(tuple("ABCDEF"), time, positions),
        coordinates=Table(("hip_flexion_r", "knee_angle_r"), time, rng.normal(size=(12, 2))),
        plates=(plate,),
        events=(GaitEvent(0.52, "l", "heel_strike"), GaitEvent(0.55, "r", "toe_off")),
        subject=Subject(height=1.7, mass=70.0),
    )


def text(name: str, content: str) -> Make:
    """Return what makes a text file."""

    def make(folder: Path) -> Path:
        (folder / name).write_text(content, encoding="utf-8")
        return folder / name

    return make


def written(name: str, writer: Callable[[Recording, Path], object]) -> Make:
    """Return what makes a recording with one of our writers."""

    def make(folder: Path) -> Path:
        writer(recording(), folder / name)
        return folder / name

    return make


COORDINATES = (
    "sample\nversion=1\nnRows=12\nnColumns=4\ninDegrees=yes\nendheader\n"
    "time\thip_flexion_r\tknee_angle_r\tpelvis_ty\n"
    + "".join(f"{0.01 * i:.3f}\t{i}\t{2 * i}\t0.9\n" for i in range(12))
)
FORCES_OF_FEET = (
    "a\nnRows=2\nendheader\ntime ground_force_vx ground_force_vy ground_force_vz "
    "ground_force_px ground_force_py ground_force_pz\n"
    "0 1 500 2 0.1 0 0.2\n0.1 1 600 2 0.1 0 0.2\n"
)
BVH = (
    "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition "
    "Zrotation Xrotation Yrotation\n JOINT Chest\n {\n  OFFSET 0 50 0\n  CHANNELS 3 Zrotation "
    "Xrotation Yrotation\n  End Site\n  {\n   OFFSET 0 50 0\n  }\n }\n}\nMOTION\nFrames: 4\n"
    "Frame Time: 0.01\n" + "0 90 0 1 2 3 4 5 6\n" * 4
)
ASF = (
    ":version 1.10\n:name sample\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n"
    ":documentation\n  a sample\n:root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n"
    "  position 0 0 0\n  orientation 0 0 0\n:bonedata\n  begin\n    id 1\n    name lowerback\n"
    "    direction 0 1 0\n    length 20\n    axis 0 0 0 XYZ\n    dof rx ry rz\n"
    "    limits (-20 45)\n (-30 30)\n (-30 30)\n  end\n:hierarchy\n  begin\n"
    "    root lowerback\n  end\n"
)
AMC = "#!comment\n:FULLY-SPECIFIED\n:DEGREES\n" + "".join(
    f"{i}\nroot 0 17 0 1 2 3\nlowerback 1 2 {i}\n" for i in range(1, 6)
)
_FRAME = [0.033, 0, 0.9, 0, *[1.0, 0, 0, 0] * 4, 0.1, *[1.0, 0, 0, 0] * 2, 0.1, *[1.0, 0, 0, 0]]
_FRAME = [*_FRAME, 0.1, *[1.0, 0, 0, 0] * 2, 0.1]
DEEPMIMIC = json.dumps({"Loop": "wrap", "Frames": [_FRAME, _FRAME]})
_LEG = {"Hip": 0.9, "Knee": 0.5, "Ankle": 0.1}
_POINTS = {
    side + joint: [[0.1 * k, height, y] for k in range(3)]
    for side, y in (("R", 0.1), ("L", -0.1))
    for joint, height in _LEG.items()
}
KEYPOINTS = json.dumps({"fps": 60, "unit": "m", "up": "y", "keypoints": _POINTS})
ROW = "{}\t1.00\t2.00\t700.00\t10.0\t20.0\t0.0\t30.0\n"
PLATES = (
    "[Force Data]\nNumberOfForcePlates=1\nSampleRate=1000.000000\nNumberOfSamples=12\n"
    "#Sample\tFX1\tFY1\tFZ1\tX1\tY1\tZ1\tMZ1\n" + "".join(map(ROW.format, range(1, 13)))
)
NORMS = "# 12 adults\nvariable, percent, mean, sd\n" + "".join(
    f"{name}, {percent}, 5.{percent}, 4.1\n"
    for name in ("knee_angle", "hip_flexion_moment")
    for percent in (0, 25, 50, 100)
)
MARKER_SET = """
name = "my lab"
[markers]
RKN1 = "knee_lateral_r"
RTH7 = { body = "femur_r", position = [0.05, -0.09, -0.2] }
"""
SQUAT = """
[task]
name = "deep squat"
base = "squat"
without = ["acceleration"]
nodes_per_second = 20
basis = "polynomial"
[parameters]
depth = 0.4
duration = 2.5
[[term]]
type = "within"
coordinate = "knee_angle_r"
low_deg = 0.0
high_deg = 10.0
[[term]]
type = "reach"
point = { body = "hand_r", position = [0.0, 0.0, -0.1], radius = 0.0 }
target = [0.4, nan, 1.0]
time = 1.0
[[term]]
type = "limits"
ranges = { knee_angle = [0.0, 2.0] }
[[stance]]
side = "r"
x = 0.0
heel_strike = -1.0
toe_off = 100.0
heading_deg = 3
[[stance]]
side = "l"
"""
WALK = """
[task]
base = "walk"
[parameters]
speed = 1.0
steps = 3
heights = [0.0, 0.1, 0.0]
turn_deg = 0
"""
TERMS = """
[[term]]
type = "contact"
friction = 0.8
used = 1.5
[[term]]
type = "above"
site = "heel_l"
height = 0.1
[[term]]
type = "torque"
joints = { knee_angle = 2.0 }
[[term]]
type = "pose"
time = 0.5
coordinates = { knee_angle_r = 0.3 }
[[term]]
type = "posture"
weights = { knee_angle = 1.0 }
targets = { knee_angle = 0.1 }
[[term]]
type = "centre-of-mass"
time = 0.3
position = [0.0, nan, 1.0]
"""
FIGURES = json.dumps(
    {
        "version": "1",
        "time_s": 1.5,
        "experiments": {
            "a": {
                "status": "ok",
                "figures": {"x": 1.0, "y": "z"},
                "goals": {"g": True},
                "time_s": 1,
            }
        },
    }
)

LONG_PLATES = PLATES.replace("Samples=12", "Samples=9000") + "".join(
    map(ROW.format, range(13, 9001))
)


def amc(folder: Path) -> Path:
    """Make a motion of two bones, its skeleton beside it."""
    (folder / "sample.asf").write_text(ASF)
    return text("sample.amc", AMC)(folder)


def asf(folder: Path) -> Path:
    """Make the same, for the skeleton to be damaged."""
    return amc(folder).with_suffix(".asf")


def npz(folder: Path) -> Path:
    """Make a motion of one hinge."""
    path = folder / "sample.npz"
    np.savez(
        path,
        time=np.arange(3) / 100,
        qpos=np.tile([0, 0, 0.9, 1, 0, 0, 0, 0.1], (3, 1)),
        qvel=np.zeros((3, 7)),
        joint_names=np.array(["root", "hip"]),
    )
    return path


def smpl(name: str, *keys: str) -> Make:
    """Return what makes a motion of SMPL's poses, within dictionaries of these keys."""

    def make(folder: Path) -> Path:
        rng, path = np.random.default_rng(0), folder / name
        poses = 0.2 * rng.normal(size=(8, 72))
        poses[:, 0] += np.pi / 2
        arrays = {"poses": poses, "trans": 0.01 * rng.normal(size=(8, 3)), "betas": np.zeros(10)}
        arrays |= {"gender": np.array("male"), "mocap_framerate": np.array(60.0)}
        if path.suffix == ".npz":
            np.savez(path, **arrays)
        else:
            contents: dict = {**arrays, "gender": b"male", "fps": np.float64(60.0)}
            for key in keys:
                contents = {key: contents}
            path.write_bytes(pickle.dumps(contents, protocol=2 if keys else 4))
        return path

    return make


def copy_of(path: Path) -> Make:
    """Return what copies a file."""
    return lambda folder: Path(shutil.copyfile(path, folder / path.name))


def policies(_: Path | None) -> Iterator[tuple[str, Make]]:
    """List the policies that come with the package."""
    yield from ((path.stem, copy_of(path)) for path in sorted(POLICIES.glob("*.npz")))


def policy(folder: Path) -> Path:
    """Copy the smallest of them: what is learned has no smaller size."""
    return copy_of(min(POLICIES.glob("*.npz"), key=lambda path: path.stat().st_size))(folder)


def no_others(_: Path | None) -> Iterator[tuple[str, Make]]:
    """List nothing: of this kind there are no files of other people."""
    yield from ()


def tasks(_: Path | None) -> Iterator[tuple[str, Make]]:
    """List the file of every task, with the parameters that it has and some terms more."""
    for name, kind in TASKS.items():
        known = {each.name: each.default for each in fields(kind)}
        options = {key: value for key, value in known.items() if value not in (None, MISSING)}
        yield name, text("a.toml", TaskFile(name, name, options).toml() + TERMS)


def long_text(name: str, content: str) -> Wholes:
    """Return what lists one long file, made here."""
    return lambda _: iter([("long", text(name, content))])


def as_table(pattern: str) -> Wholes:
    """Return what lists recordings of the data folder, written as CSV."""

    def converted(path: Path) -> Make:
        def make(folder: Path) -> Path:
            write_csv(read(path), folder / "long.csv")
            return folder / "long.csv"

        return make

    return lambda data: (
        (name, converted(data / name)) for name, _ in recordings(pattern)(data) if data
    )


def recordings(pattern: str, *beside: str) -> Wholes:
    """Return what lists recordings of the data folder, and copies them with what lies beside them.

    Args:
        pattern: Their names, within the data folder.
        beside: Names of what belongs to them: ``{start}`` is what comes before an underscore.
    """

    def copied(path: Path) -> Make:
        def make(folder: Path) -> Path:
            start = path.stem.partition("_")[0]
            along = [sorted(path.parent.glob(name.format(start=start)))[:1] for name in beside]
            for each in [path, *(found for some in along for found in some)]:
                shutil.copyfile(each, folder / each.name)
            return folder / path.name

        return make

    def listed(data: Path | None) -> Iterator[tuple[str, Make]]:
        for path in sorted(data.glob(pattern)) if data is not None else []:
            if path.is_file() and path.stat().st_size <= LARGEST:
                yield path.relative_to(data).as_posix(), copied(path)

    return listed


_WAVE = base64.b64encode(np.ones((2, 101), "<f4").tobytes()).decode()
BATCH_CURVES = json.dumps({"name": "a", "curves": {"knee_angle_r": ["deg", 2, _WAVE]}}) + "\n"
BATCH_ITEMS = "".join(
    json.dumps(line) + "\n"
    for line in (
        {"name": "", "method": "fit", "settings": {}},
        {"name": "a", "number": 0, "file": "/x/a.c3d", "key": "k", "status": "ok", "failed": False,
         "seconds": 1.5, "varied": {"push": "none"}, "figures": {"gps_deg": 7.3, "sex": "male"}},
        {"name": "b", "number": 1, "status": "is damaged", "failed": True, "figures": {}},
    )
)  # fmt: skip
"""The journals of a batch."""
