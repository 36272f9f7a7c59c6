"""A Record comes back from its file as it was, and damaged files end in our own error."""

import io
import json
import zipfile
from dataclasses import fields

import numpy as np
import pytest

from plantigrade import Ground
from plantigrade.contact.ground import GroundStep, Seat
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.errors import FileError
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Markers, Motion
from plantigrade.notes import Info
from plantigrade.record import Condition, Limits, Record, Run
from plantigrade.record.npz import npz_bytes, read_npz, write_npz
from tests.nasty.npz import HEADERS, npy

HUMAN = Human.create(height=1.68, mass=61.0, sex="female", feet="two-segment")
HUMAN = HUMAN.with_soles({HUMAN.contact_points[0][0]: -0.01})


def a_motion(time, seed=0):
    rng = np.random.default_rng(seed)
    qpos = np.tile(HUMAN.standing(), (len(time), 1))
    qpos[:, 7:] += rng.normal(scale=0.1, size=qpos[:, 7:].shape)
    return Motion(
        time, qpos, rng.normal(size=(len(time), HUMAN.model.nv)), joint_names=HUMAN.joint_names
    )


def a_record(n=5):
    """Return a Record in which every field holds something."""
    rng = np.random.default_rng(0)
    time, model = np.arange(n) / 100, HUMAN.model
    nv, hinges = model.nv, model.nv - 6
    chair = ContactSite(body="pelvis", position=(-0.1, 0.0, -0.05), name="seat", part="chair")
    plate = ContactSite(body="foot_l", name="plate_1", side="l", measured=True)
    sites = (*contact_sites(HUMAN)[:2], chair, plate)
    k = len(sites)
    base = a_motion(time)
    return Record(
        HUMAN,
        Motion(
            time,
            base.qpos,
            base.qvel,
            HUMAN.joint_names,
            rng.normal(size=(n, nv)),
            (GaitEvent(0.01, "r", "heel_strike"), GaitEvent(0.03, "l", "toe_off")),
        ),
        qfrc_actuator=rng.normal(size=(n, nv)),
        sites=sites,
        contact_force=rng.normal(size=(n, k, 3)),
        contact_point=np.full((n, k, 3), np.nan),
        contact_torque=rng.normal(size=(n, k, 3)),
        contact_known=rng.random((n, k)) > 0.5,
        contact_planned=rng.random((n, k)) > 0.5,
        ground=Ground(
            0.02,
            0.1,
            (GroundStep(0.5, 0.1), GroundStep(1.0, 0.2)),
            (Seat("seat", (0.0, 0.0, 0.45)),),
            0.6,
        ),
        limits=Limits(
            coordinate=np.stack([-np.ones(hinges), np.ones(hinges)]),
            velocity=rng.random(hinges),
            torque=np.stack([-np.ones(hinges), np.ones(hinges)]),
            force=900.0,
        ),
        signals={
            "solver.history": rng.normal(size=(3, 5)),
            "solver.stage_names": np.array(["coarse", "fine"]),
            "tasks.active": np.array([[True, False]] * n),
        },
        references={"recorded": a_motion(time, 1), "guess": a_motion(np.arange(3) / 10, 2)},
        recorded_markers=Markers(("A", "Ferse"), time, rng.normal(size=(n, 2, 3))),
        fitted_markers=rng.normal(size=(n, 2, 3)),
        clock=12.5,
        conditions=(
            Condition("knee", "coordinate", (0.0, 0.02), (0.0, 0.0), (0.2, 0.3), "knee_angle_r"),
        ),
        notes=("marker LHEE is missing — its gaps were closed", Info("Walked at 1.3 m/s.")),
    )


def same(a, b):
    if isinstance(a, Human):
        assert a.to_dict() == b.to_dict() and a.xml == b.xml
    elif isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b)
    elif isinstance(a, dict):
        assert list(a) == list(b)
        for key in a:
            same(a[key], b[key])
    elif hasattr(a, "__dataclass_fields__"):
        for field in fields(a):
            same(getattr(a, field.name), getattr(b, field.name))
    else:
        assert a == b


def test_every_field_comes_back(tmp_path):
    record = a_record()
    for field in fields(Record):  # else this test would say less than it should
        assert str(getattr(record, field.name)) not in ("None", "()", "{}", "0.0"), field.name
    same(record, read_npz(write_npz(record, tmp_path / "motion.npz")))


def test_notes_keep_their_kind_and_those_of_older_files_are_warnings(tmp_path):
    record = read_npz(write_npz(a_record(), tmp_path / "motion.npz"))
    assert [isinstance(note, Info) for note in record.notes] == [False, True]
    assert Run(record, "fit").metrics["warnings"] == list(record.notes[:1])
    older = read_npz(rewritten(tmp_path, notes_info=None))
    assert older.notes == record.notes and not any(isinstance(n, Info) for n in older.notes)


def test_the_bare_record_comes_back(tmp_path):
    record = Record(HUMAN, a_motion(np.arange(4) / 50))
    same(record, read_npz(write_npz(record, tmp_path / "motion.npz")))


@pytest.mark.parametrize("limits", [Limits(), Limits(velocity=12.0)])
def test_limits_of_one_number_or_none(tmp_path, limits):
    record = Record(HUMAN, a_motion(np.arange(2) / 50), limits=limits)
    same(record, read_npz(write_npz(record, tmp_path / "motion.npz")))


def test_equal_records_give_equal_bytes():
    assert npz_bytes(a_record()) == npz_bytes(a_record())


def test_plain_numpy_reads_it(tmp_path):
    record = a_record()
    with np.load(write_npz(record, tmp_path / "motion.npz"), allow_pickle=False) as archive:
        assert tuple(archive["joint_names"]) == HUMAN.joint_names
        assert list(archive["contact_segment"]) == [site.body for site in record.sites]
        assert archive["contact_side"].tolist() == [site.side for site in record.sites]
        np.testing.assert_array_equal(
            archive["reference_qpos"], record.references["recorded"].qpos
        )  # the first on the same clock
        assert json.loads(str(archive["human"]))["height"] == HUMAN.height


def rewritten(tmp_path, **changes):
    """Write a record's file again with some arrays changed, or left out where None."""
    path = write_npz(a_record(), tmp_path / "motion.npz")
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays = {k: v for k, v in (arrays | changes).items() if v is not None}
    np.savez(path, **arrays)
    return path


HUGE_CONDITION = json.dumps(
    [Condition("knee", "coordinate", (0.0, 0.5), (0.0, 0.0), (0.2, 0.3), "knee_angle_r").to_dict()]
).replace("0.5", "1" + "0" * 400)
NQ, NV = HUMAN.model.nq, HUMAN.model.nv


@pytest.mark.parametrize(
    ("key", "value", "match"),
    [
        ("qpos", np.zeros((4, NQ)), rf"qpos: has shape \(4, {NQ}\), not \(5, {NQ}\)"),
        ("qpos", np.zeros((5, NQ - 1)), "qpos: has shape"),
        ("qpos", None, "qpos: is missing"),
        ("qvel", np.array([["x"] * NV] * 5), "qvel: holds"),
        ("qacc", np.zeros((5, 7)), "qacc: has shape"),
        ("time", np.array([0, 1, 1, 2, 3.0]), "time: does not increase"),
        ("time", np.array([0, 1, np.nan, 2, 3]), "time: does not increase"),
        ("joint_names", np.zeros(3), "joint_names: is not a list of words"),
        ("joint_names", np.array(["root", "knee"]), "hinges"),
        ("joint_names", np.array(["a", None], dtype=object), "cannot be|plain arrays"),
        ("human", None, "human: is missing"),
        ("human", np.array("{"), "human: is damaged"),
        ("human", np.array('{"height": "tall"}'), "human: is damaged"),
        ("human", np.array('{"height": 17.4}'), "human: is damaged"),
        ("human", np.array("[" * 100_000), "human: is damaged"),
        ("ground", np.array('{"slope": "steep"}'), "ground: is damaged"),
        ("conditions", np.array(HUGE_CONDITION), "conditions: is damaged"),
        ("ground", np.array("7"), "ground: is no JSON object"),
        ("contact_side", np.array(["l"]), "contact_side: has 1 words, not 4"),
        ("contact_side", np.array(["up"] * 4), "contact_name: does not describe"),
        ("contact_radius", None, "contact_radius: is missing"),
        ("contact_force", np.zeros((5, 3, 3)), "contact_force: has shape"),
        ("contact_known", np.zeros((4, 4)), "contact_known: has shape"),
        ("event_side", None, "event_side"),
        ("limit_velocity", np.zeros(3), "limit_velocity: has shape"),
        ("marker_time", np.zeros(5), "marker_time: does not increase"),
        ("signal/solver.history", np.zeros(3, dtype=complex), "neither numbers nor words"),
        ("reference/recorded/time", np.zeros(5), "reference/recorded/time: does not increase"),
        ("reference/recorded/qvel", None, "reference/recorded/qvel: is missing"),
        ("reference/recorded/qpos", np.zeros((5, 7)), "reference/recorded/qpos: has shape"),
    ],
)
def test_a_wrong_array_is_named(tmp_path, key, value, match):
    with pytest.raises(FileError, match=match) as caught:
        read_npz(rewritten(tmp_path, **{key: value}))
    assert caught.value.remedy


def test_broken_files(tmp_path):
    path = write_npz(a_record(), tmp_path / "motion.npz")
    raw = path.read_bytes()
    for broken in (raw[: len(raw) // 2], raw[:-10], b"", b"PK\x03\x04", b"hello"):
        path.write_bytes(broken)
        with pytest.raises(FileError):
            read_npz(path)
    with pytest.raises(FileError, match="no such file"):
        read_npz(tmp_path / "gone.npz")
    with pytest.raises(FileError, match="is a folder"):
        read_npz(tmp_path)


@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS)
@pytest.mark.parametrize("version", [1, 3])
def test_headers_that_numpy_stumbles_over(tmp_path, header, version):
    path = tmp_path / "motion.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("time.npy", npy(header, version))
    with pytest.raises(FileError, match="plain arrays|cannot be read|is missing"):
        read_npz(path)


def bomb(path, keys, rows):
    block = io.BytesIO()
    np.save(block, np.zeros(rows))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key in keys:
            archive.writestr(f"{key}.npy", block.getvalue())


def test_a_file_that_unpacks_to_too_much_is_refused(tmp_path):
    path = tmp_path / "motion.npz"
    bomb(path, range(10), 60 * 2**17)
    with pytest.raises(FileError, match=r"would decompress to 600 MiB in 10 arrays"):
        read_npz(path)
    bomb(path, range(1200), 1)
    with pytest.raises(FileError, match=r"in 1200 arrays"):
        read_npz(path)


def test_cannot_write(tmp_path):
    with pytest.raises(FileError, match="cannot be written"):
        write_npz(a_record(), tmp_path / "gone" / "motion.npz")
