import io
import zipfile
from dataclasses import fields, replace

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.motion.motion import Motion
from plantigrade.motion.recording import GaitEvent, Markers
from plantigrade.record.npz import read_npz, write_npz
from plantigrade.record.record import Record


def a_record(n=5, nq=9, nv=8, k=2):
    rng = np.random.default_rng(0)
    time = np.arange(n) / 100
    return Record(
        motion=Motion(
            time,
            rng.normal(size=(n, nq)),
            rng.normal(size=(n, nv)),
            ("root", "knee_angle_r", "knee_angle_l"),
            rng.normal(size=(n, nv)),
            (GaitEvent(0.01, "r", "heel_strike"), GaitEvent(0.03, "l", "toe_off")),
        ),
        qfrc_actuator=rng.normal(size=(n, nv)),
        contact_force=rng.normal(size=(n, k, 3)),
        contact_point=np.full((n, k, 3), np.nan),
        contact_torque=rng.normal(size=(n, k, 3)),
        contact_side=("l", "r"),
        contact_segment=("heel_l", "heel_r"),
        reference_qpos=rng.normal(size=(n, nq)),
        recorded_markers=Markers(("A", "Ferse"), time, rng.normal(size=(n, 2, 3))),
        fitted_markers=rng.normal(size=(n, 2, 3)),
        warnings=("a marker is missing — look",),
    )


def same(a, b):
    if isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b)
    elif hasattr(a, "__dataclass_fields__"):
        for field in fields(a):
            same(getattr(a, field.name), getattr(b, field.name))
    else:
        assert a == b


def test_round_trip(tmp_path):
    for record in (a_record(), Record(motion=replace(a_record().motion, qacc=None, events=()))):
        same(record, read_npz(write_npz(record, tmp_path / "motion.npz")))


def test_plain_numpy_reads_it(tmp_path):
    path = write_npz(a_record(), tmp_path / "motion.npz")
    with np.load(path, allow_pickle=False) as archive:
        assert archive["qpos"].shape == (5, 9)
        assert list(archive["joint_names"]) == ["root", "knee_angle_r", "knee_angle_l"]
        assert list(archive["contact_side"]) == ["l", "r"]


@pytest.mark.parametrize(
    ("key", "value", "match"),
    [
        ("qpos", np.zeros((4, 9)), r"qpos: has shape \(4, 9\), not \(5, any\)"),
        ("qpos", None, "no qpos"),
        ("time", np.array([0, 1, 1, 2, 3.0]), "time: does not increase"),
        ("time", np.array([0, 1, np.nan, 2, 3]), "time: does not increase"),
        ("qvel", np.array([["x"] * 8] * 5), "qvel: holds"),
        ("contact_side", np.array(["l"]), "contact_side: has 1 words, not 2"),
        ("joint_names", np.zeros(3), "joint_names: is not a list of words"),
        ("event_side", None, "event_side"),
        ("qacc", np.zeros((5, 7)), "qacc: has shape"),
        ("joint_names", np.array(["a", None], dtype=object), "cannot be read"),
    ],
)
def test_bad_arrays(tmp_path, key, value, match):
    path = write_npz(a_record(), tmp_path / "motion.npz")
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays.pop(key)
    if value is not None:
        arrays[key] = value
    np.savez(path, **arrays)
    with pytest.raises(FileError, match=match):
        read_npz(path)


def test_broken_files(tmp_path):
    path = write_npz(a_record(), tmp_path / "motion.npz")
    raw = path.read_bytes()
    for broken in (raw[: len(raw) // 2], raw[:-10], b"", b"PK\x03\x04", b"hello"):
        path.write_bytes(broken)
        with pytest.raises(FileError):
            read_npz(path)
    rng = np.random.default_rng(1)
    for _ in range(60):  # single bytes changed: our error or a whole record, nothing else
        changed = bytearray(raw)
        changed[rng.integers(len(raw))] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(changed))
        try:
            read_npz(path)
        except FileError:
            pass
    with pytest.raises(FileError, match="no such file"):
        read_npz(tmp_path / "gone.npz")
    with pytest.raises(FileError, match="cannot be read"):
        read_npz(tmp_path)


def test_zip_bomb(tmp_path):
    path = tmp_path / "motion.npz"
    block = io.BytesIO()
    np.save(block, np.zeros(60 * 2**17))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key in range(10):
            archive.writestr(f"{key}.npy", block.getvalue())
    with pytest.raises(FileError, match=r"would unpack to 600 MiB in 10 arrays"):
        read_npz(path)


def test_cannot_write(tmp_path):
    with pytest.raises(FileError, match="cannot be written"):
        write_npz(a_record(), tmp_path / "gone" / "motion.npz")
