"""Every reader, given every kind of broken file: a Recording, or an error that names the file.

One table of formats with a small valid sample each; new formats join by adding a line.
"""

import struct
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from plantigrade.errors import FileError
from plantigrade.io import FORMATS, read
from plantigrade.io.c3d_writer import write_c3d
from plantigrade.io.csv import write_csv
from plantigrade.io.trc import write_trc
from plantigrade.motion import ForcePlate, GaitEvent, Markers, Recording, Subject, Table

LIMIT_S = 20.0  # of the processor: what grows without bound takes longer
LIMIT_BYTES = 500e6


def recording() -> Recording:
    """Six markers, a force plate and two events, 12 frames."""
    rng = np.random.default_rng(0)
    time = 0.5 + np.arange(12) / 100
    positions = rng.normal(size=(12, 6, 3)) * 0.01 + np.linspace(0.1, 1.7, 6)[:, None] * [
        0.1,
        0.1,
        1,
    ]
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


def written(writer: Callable[[Recording, Path], object]) -> Callable[[Path], None]:
    """Return what writes the sample with ``writer``."""
    return lambda path: writer(recording(), path) and None


def write_mot(path: Path) -> None:
    """Write joint coordinates."""
    rows = "".join(f"{0.01 * i:.3f}\t{i}\t{2 * i}\t0.9\n" for i in range(12))
    path.write_text(
        "sample\nversion=1\nnRows=12\nnColumns=4\ninDegrees=yes\nendheader\n"
        "time\thip_flexion_r\tknee_angle_r\tpelvis_ty\n" + rows
    )


def write_bvh(path: Path) -> None:
    """Write a skeleton of two joints."""
    path.write_text(
        "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition "
        "Zrotation Xrotation Yrotation\n JOINT Chest\n {\n  OFFSET 0 50 0\n  CHANNELS 3 Zrotation "
        "Xrotation Yrotation\n  End Site\n  {\n   OFFSET 0 50 0\n  }\n }\n}\nMOTION\nFrames: 4\n"
        "Frame Time: 0.01\n" + "0 90 0 1 2 3 4 5 6\n" * 4
    )


def write_amc(path: Path) -> None:
    """Write a motion of two bones, its skeleton beside it."""
    path.with_suffix(".asf").write_text(
        ":version 1.10\n:name sample\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n"
        ":documentation\n  a sample\n:root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n"
        "  position 0 0 0\n  orientation 0 0 0\n:bonedata\n  begin\n    id 1\n    name lowerback\n"
        "    direction 0 1 0\n    length 20\n    axis 0 0 0 XYZ\n    dof rx ry rz\n"
        "    limits (-20 45)\n (-30 30)\n (-30 30)\n  end\n:hierarchy\n  begin\n"
        "    root lowerback\n  end\n"
    )
    frames = "".join(f"{i}\nroot 0 17 0 1 2 3\nlowerback 1 2 {i}\n" for i in range(1, 6))
    path.write_text("#!comment\n:FULLY-SPECIFIED\n:DEGREES\n" + frames)


def write_deepmimic(path: Path) -> None:
    """Write two frames."""
    frame = [0.033, 0, 0.9, 0] + [1.0, 0, 0, 0] * 4 + [0.0] * 0
    row = [*frame, 0.1, *[1.0, 0, 0, 0] * 2, 0.1, *[1.0, 0, 0, 0], 0.1]
    row += [1.0, 0, 0, 0] * 2
    row = (row + [0.1] * 44)[:44]
    path.write_text(f'{{"Loop": "wrap", "Frames": [{row}, {row}]}}')


def write_forces(path: Path) -> None:
    """Write a foot on one plate."""
    rows = "".join(f"{i}\t1.00\t2.00\t700.00\t10.0\t20.0\t0.0\t30.0\n" for i in range(1, 13))
    path.write_text(
        "[Force Data]\nNumberOfForcePlates=1\nSampleRate=1000.000000\nNumberOfSamples=12\n"
        "#Sample\tFX1\tFY1\tFZ1\tX1\tY1\tZ1\tMZ1\n" + rows
    )


def write_npz(path: Path) -> None:
    """Write a motion of one hinge."""
    np.savez(
        path,
        time=np.arange(3) / 100,
        qpos=np.tile([0, 0, 0.9, 1, 0, 0, 0, 0.1], (3, 1)),
        qvel=np.zeros((3, 7)),
        joint_names=np.array(["root", "hip"]),
    )


SAMPLES: dict[str, tuple[str, Callable[[Path], None]]] = {
    "C3D": (".c3d", written(write_c3d)),
    "TRC": (".trc", written(write_trc)),
    "CSV": (".csv", written(write_csv)),
    "MOT/STO": (".mot", write_mot),
    "BVH": (".bvh", write_bvh),
    "AMC": (".amc", write_amc),
    "DeepMimic": (".json", write_deepmimic),
    "forces": (".forces", write_forces),
    "npz": (".npz", write_npz),
}
NAMES = tuple(SAMPLES)
TEXT = tuple(name for name in NAMES if name not in ("C3D", "npz"))

many = settings(
    max_examples=60,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture(scope="module")
def samples(tmp_path_factory) -> dict[str, tuple[Path, bytes]]:
    """A valid file of each format, and its bytes."""
    found = {}
    for name, (suffix, make) in SAMPLES.items():
        path = tmp_path_factory.mktemp("sample") / f"sample{suffix}"
        make(path)
        found[name] = (path, path.read_bytes())
    return found


def survives(path: Path, content: bytes) -> None:
    """Read ``content``: a recording, or an error that names the file; in time and memory."""
    path.write_bytes(content)
    start = time.process_time()
    try:
        read(path)
    except FileError as error:
        names = (path.name, path.with_suffix(".asf").name)
        assert any(name in str(error) for name in names), error
        assert error.remedy, f"no remedy in: {error}"
    assert time.process_time() - start < LIMIT_S


def test_every_format_has_a_sample():
    """A format that joins the table joins this harness."""
    assert {kind.name for kind in FORMATS} == set(SAMPLES)


@pytest.mark.parametrize("name", NAMES)
def test_the_sample_itself_is_read(samples, name):
    """Otherwise nothing below says anything."""
    path, content = samples[name]
    path.write_bytes(content)
    found = read(path)
    assert found.markers or found.skeleton or found.coordinates or found.plates


@pytest.mark.parametrize("name", NAMES)
@many
@given(cut=st.floats(0, 1))
def test_truncated(samples, name, cut):
    """A file that ends anywhere."""
    path, content = samples[name]
    survives(path, content[: int(cut * len(content))])


@pytest.mark.parametrize("name", NAMES)
@many
@given(changes=st.lists(st.tuples(st.floats(0, 0.9999), st.integers(0, 255)), max_size=8))
def test_changed_bytes(samples, name, changes):
    """A few bytes are others, more often near the front, where headers are."""
    path, content = samples[name]
    broken = bytearray(content)
    for where, value in changes:
        broken[int(where**2 * len(broken))] = value
    survives(path, bytes(broken))


@pytest.mark.parametrize("name", NAMES)
@many
@given(content=st.binary(max_size=3000), keep=st.sampled_from([0, 2, 16, 64, 512, 1024]))
def test_random_bytes(samples, name, content, keep):
    """Noise, or noise after a good start."""
    path, good = samples[name]
    survives(path, good[:keep] + content)


@pytest.mark.parametrize("name", TEXT)
@many
@given(seed=st.integers(0, 2**32 - 1))
def test_reordered_lines(samples, name, seed):
    """Lines in another order, some lost, some twice."""
    path, content = samples[name]
    lines = content.split(b"\n")
    order = np.random.default_rng(seed).integers(0, len(lines), len(lines))
    survives(path, b"\n".join(lines[i] for i in order))


@pytest.mark.parametrize("name", TEXT)
@many
@given(
    word=st.sampled_from(
        [b"nan", b"NaN", b"", b"inf", b"-inf", b"1e400", b"x", b"99999999999999999999", b"-5"]
    ),
    share=st.floats(0, 1),
    seed=st.integers(0, 2**32 - 1),
)
def test_words_instead_of_numbers(samples, name, word, share, seed):
    """NaN, blanks, infinities, letters, and absurd counts in place of any number."""
    import re

    path, content = samples[name]
    rng = np.random.default_rng(seed)
    survives(
        path,
        re.sub(rb"-?\d+(\.\d+)?", lambda m: word if rng.random() < share else m[0], content),
    )


@pytest.mark.parametrize("name", TEXT)
@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252"])
@pytest.mark.parametrize("cut", [0, 1])
def test_other_encodings(samples, name, encoding, cut):
    """Another encoding, also with its last byte lost."""
    path, content = samples[name]
    raw = content.decode().encode(encoding)
    survives(path, raw[: len(raw) - cut])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("content", [b"", b"\0", b"\n" * 50, b"\0" * 5000, b"\xff" * 5000, b" "])
def test_nothing_in_it(samples, name, content):
    """An empty file, blanks, zeros."""
    path, _ = samples[name]
    path.write_bytes(content)
    with pytest.raises(FileError):
        read(path)


@pytest.mark.parametrize("name", NAMES)
def test_a_huge_file_is_refused_unread(samples, tmp_path, name):
    """Ten gigabytes of nothing behind a good start: an error, no memory taken."""
    path, good = samples[name]
    huge = tmp_path / f"huge{path.suffix}"
    if name == "AMC":
        huge.with_suffix(".asf").write_bytes(path.with_suffix(".asf").read_bytes())
    with open(huge, "wb") as file:
        file.write(good)
        file.truncate(10_000_000_000)
    tracemalloc.start()
    start = time.process_time()
    with pytest.raises(FileError, match=huge.name):
        read(huge)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert time.process_time() - start < LIMIT_S and peak < LIMIT_BYTES


@pytest.mark.parametrize("name", TEXT)
@pytest.mark.parametrize("number", [b"1000000000", b"99999999999999999999", b"-1", b"0"])
def test_absurd_counts(samples, name, number):
    """Each number of the header in turn announces a thousand million of something."""
    import re

    path, content = samples[name]
    tracemalloc.start()
    for match in list(re.finditer(rb"\d+", content))[:40]:
        survives(path, content[: match.start()] + number + content[match.end() :])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < LIMIT_BYTES


@pytest.mark.parametrize("word", range(12))
@pytest.mark.parametrize("value", [0, 1, 255, 32767, 32768, 65535])
def test_absurd_c3d_header(samples, word, value):
    """Each word of the C3D header in turn."""
    path, content = samples["C3D"]
    broken = bytearray(content)
    struct.pack_into("<H", broken, 2 * word, value)
    tracemalloc.start()
    survives(path, bytes(broken))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < LIMIT_BYTES


def test_hundreds_of_changed_c3d_headers(samples):
    """Headers and parameters, changed everywhere."""
    path, content = samples["C3D"]
    rng = np.random.default_rng(1)
    for _ in range(500):
        broken = bytearray(content)
        for _ in range(rng.integers(1, 6)):
            broken[rng.integers(0, min(len(broken), 6000))] = rng.integers(0, 256)
        survives(path, bytes(broken))


def test_missing_and_folder(tmp_path):
    """What is not a file at all."""
    for kind in FORMATS:
        for suffix in kind.suffixes:
            with pytest.raises(FileError, match="no such file"):
                read(tmp_path / f"absent{suffix}")
    with pytest.raises(FileError, match="folder"):
        read(tmp_path)
