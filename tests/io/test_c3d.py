"""C3D: against ezc3d, against the physics of standing and walking, and byte by byte."""

from pathlib import Path

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import force_plates
from plantigrade.io.c3d import event_kind, event_side, read_c3d
from plantigrade.io.c3d_file import read_c3d_file
from plantigrade.io.c3d_writer import write_c3d
from plantigrade.io.force_plates import COP_THRESHOLD, plate_axes
from plantigrade.motion import GaitEvent, Markers, Recording
from tests.io.c3d_bytes import DEC, INTEL, MIPS, build

FILES = (
    "HC032A01 HC032A03 HC038A01 HC038A11 HC038A27 opensim_walking2 gaitalytics_treadmill_events"
).split()
FEET = {
    "HC": ("HEE", "TOE", "ANK", "P5M", "HLX"),
    "op": ("CAL", "MT2", "MT1", "LMAL", "MMAL"),
    "ga": ("HEE", "MT2", "MT5", "LM", "MM"),
}
CORNERS = np.array([[0.6, 0.4, 0], [0.6, 0, 0], [0, 0, 0], [0, 0.4, 0]])  # clockwise from above


# ------------------------------------------------------------------------- against ezc3d


@pytest.mark.parametrize("name", FILES)
def test_numbers_are_those_ezc3d_reads(data, name):
    """Points, gaps, analog samples, clocks."""
    ezc3d = pytest.importorskip("ezc3d")
    path = data / "c3d" / f"{name}.c3d"
    ours, other = read_c3d_file(path), ezc3d.c3d(str(path))
    points = other["data"]["points"][:3].transpose(2, 1, 0)
    seen = np.isfinite(ours.points).all(axis=2)
    np.testing.assert_array_equal(ours.points[seen], points[seen])
    assert not np.nan_to_num(points[~seen]).any()  # what we call a gap is one
    np.testing.assert_array_equal(ours.analog, other["data"]["analogs"][0].T)
    assert ours.first_frame == other["header"]["points"]["first_frame"] + 1
    assert ours.rate == other["header"]["points"]["frame_rate"]
    assert ours.analog_rate == other["header"]["analogs"]["frame_rate"]


@pytest.mark.parametrize("name", FILES)
def test_plates_agree_with_ezc3d(data, name, monkeypatch):
    """Force, centre of pressure, free moment of every loaded sample, up to the force's sense.

    ezc3d leaves the baseline of an unloaded plate in; so do we here.
    """
    ezc3d = pytest.importorskip("ezc3d")
    monkeypatch.setattr(force_plates, "unloaded", lambda time, vertical: None)
    path = data / "c3d" / f"{name}.c3d"
    plates = read_c3d(path).plates
    others = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"]
    assert len(plates) == len(others) == 2
    for plate, other in zip(plates, others, strict=True):
        loaded = plate.force[:, 2] > 50
        sign = np.sign((plate.force * other["force"].T).sum()) or 1.0
        force, moment = sign * other["force"].T, sign * 1e-3 * other["Tz"].T[:, 2]
        np.testing.assert_allclose(plate.force, force, atol=1e-5)
        cop = 1e-3 * other["center_of_pressure"].T[loaded]
        np.testing.assert_allclose(plate.cop[loaded], cop, atol=1e-7)
        np.testing.assert_allclose(plate.free_moment[loaded], moment[loaded], atol=1e-6)


# ------------------------------------------------------------------------- physics


@pytest.mark.parametrize("name", [n for n in FILES if n not in ("HC032A01", "HC038A01")])
def test_forces_are_on_the_body(data, name):
    """Up; the centre of pressure under one foot; never pulling; small free moment."""
    recording = read_c3d(data / "c3d" / f"{name}.c3d")
    markers = recording.markers
    for plate in recording.plates:
        fz = np.interp(markers.time, plate.time, plate.force[:, 2])
        heavy = fz > 200
        assert heavy.any() and plate.force[:, 2].min() > -60
        cop = np.stack(
            [np.interp(markers.time, plate.time, np.nan_to_num(c)) for c in plate.cop.T], axis=1
        )
        under = np.zeros(heavy.sum(), dtype=bool)
        for side in "LR":
            foot = markers.select([side + m for m in FEET[name[:2]]]).positions[heavy, :, :2]
            inside = (cop[heavy, :2] > np.nanmin(foot, axis=1) - 0.04) & (
                cop[heavy, :2] < np.nanmax(foot, axis=1) + 0.04
            )
            under |= inside.all(axis=1)
        assert under.mean() > 0.85
        assert np.abs(plate.free_moment[plate.force[:, 2] > 200]).max() < 12  # [N m]
        assert np.isnan(plate.cop[np.abs(plate.force[:, 2]) < COP_THRESHOLD]).all()


@pytest.mark.parametrize("name", ["HC032A03", "HC038A11", "opensim_walking2"])
def test_a_step_brakes_and_then_pushes(data, name):
    """Along the way the body goes, the force is backward in early stance, forward in late."""
    recording = read_c3d(data / "c3d" / f"{name}.c3d")
    markers = recording.markers
    asis = markers.select(["LASI", "RASI"]).positions.mean(axis=1)
    for plate in recording.plates:
        loaded = np.flatnonzero(plate.force[:, 2] > 50)
        near = (markers.time >= plate.time[loaded[0]]) & (markers.time <= plate.time[loaded[-1]])
        path = asis[near][np.isfinite(asis[near]).all(axis=1)]
        forward = path[-1] - path[0]
        along = plate.force[loaded] @ (forward / np.linalg.norm(forward))
        n = len(along)
        assert along[: n // 3].mean() < -20 and along[-n // 3 :].mean() > 20


@pytest.mark.parametrize("name", ["HC032A01", "HC038A01"])
def test_who_stands_still_weighs_what_the_file_says(data, name):
    """Body weight from the plate within 3 % of the mass in PROCESSING."""
    recording = read_c3d(data / "c3d" / f"{name}.c3d")
    weight = sum(plate.force[:, 2].mean() for plate in recording.plates)
    assert weight == pytest.approx(9.81 * recording.subject.mass, rel=0.03)


@pytest.mark.parametrize("name", FILES)
def test_markers_are_on_a_body_of_the_right_size(data, name):
    """Above the floor, below the crown, and none that a model computed."""
    recording = read_c3d(data / "c3d" / f"{name}.c3d")
    z = recording.markers.positions[..., 2]
    assert -0.05 < np.nanmin(z) and 1.0 < np.nanmax(z) < 2.0
    names = set(recording.markers.names)
    assert "C7" in names and not names & {"HEDO", "PELA", "LHJC", "CentreOfMass", "LHDF0", "LHE1"}
    assert not any("Angles" in n or n.startswith("*") for n in names)
    if name == "gaitalytics_treadmill_events":  # a model's copies of markers under other names
        assert {"LASIS", "LLEK"} <= names and not names & {"LASI", "LKNE"}


def test_events_and_clock(data):
    """Time is (frame - 1) / rate; heel strikes as listed with the recording."""
    recording = read_c3d(data / "c3d" / "HC038A11.c3d")
    assert recording.markers.time[0] == pytest.approx(2.69)
    strikes = {
        side: [e.time for e in recording.events if (e.side, e.kind) == (side, "heel_strike")]
        for side in "lr"
    }
    np.testing.assert_allclose(strikes["l"], [2.81, 3.87, 4.93], atol=1e-6)
    np.testing.assert_allclose(strikes["r"], [3.34, 4.38], atol=1e-6)
    assert recording.subject.height == pytest.approx(1.74)


@pytest.mark.parametrize("name", FILES)
def test_round_trip(data, tmp_path, name):
    """What is written is read back to the precision of the file."""
    path = tmp_path / "again.c3d"
    once = read_c3d(data / "c3d" / f"{name}.c3d")
    write_c3d(once, path)
    again = read_c3d(path)
    assert again.markers.names == once.markers.names and again.warnings == ()
    np.testing.assert_allclose(again.markers.positions, once.markers.positions, atol=1e-6)
    np.testing.assert_allclose(again.markers.time, once.markers.time, atol=1e-9)
    for new, old in zip(again.plates, once.plates, strict=True):
        np.testing.assert_allclose(new.force, old.force, atol=1e-3)
        np.testing.assert_allclose(new.cop, old.cop, atol=1e-5)
        np.testing.assert_allclose(new.free_moment, old.free_moment, atol=1e-4)
    assert [(e.side, e.kind) for e in again.events] == [(e.side, e.kind) for e in once.events]
    assert [e.time for e in again.events] == pytest.approx([e.time for e in once.events], abs=1e-4)
    assert again.subject.mass == pytest.approx(once.subject.mass) if once.subject.mass else True


@pytest.mark.parametrize("name", FILES)
def test_ezc3d_reads_what_is_written(data, tmp_path, name):
    """The other library finds the same points, gaps, clock, forces and events in our file."""
    ezc3d = pytest.importorskip("ezc3d")
    path = tmp_path / "again.c3d"
    once = read_c3d(data / "c3d" / f"{name}.c3d")
    write_c3d(once, path)
    other = ezc3d.c3d(str(path), extract_forceplat_data=True)
    parameters = other["parameters"]
    assert tuple(parameters["POINT"]["LABELS"]["value"]) == once.markers.names
    assert parameters["POINT"]["UNITS"]["value"] == ["mm"]
    points = other["data"]["points"][:3].transpose(2, 1, 0)
    np.testing.assert_allclose(points, 1e3 * once.markers.positions, rtol=1e-6, atol=1e-3)
    header = other["header"]["points"]
    assert header["frame_rate"] == pytest.approx(once.markers.rate)
    assert header["first_frame"] / header["frame_rate"] == pytest.approx(once.markers.time[0])
    for theirs, plate in zip(other["data"]["platform"], once.plates, strict=True):
        upwards = np.linalg.norm(theirs["force"], axis=0)
        np.testing.assert_allclose(upwards, np.linalg.norm(plate.force, axis=1), atol=1e-3)
        corners = 1e-3 * theirs["corners"].T
        np.testing.assert_allclose(sorted(corners.tolist()), sorted(plate.corners.tolist()))
    if once.events:
        times = parameters["EVENT"]["TIMES"]["value"]
        found = 60 * times[0] + times[1]
        np.testing.assert_allclose(found, [e.time for e in once.events], atol=1e-4)


def many(n: int, letters: int = 6) -> Recording:
    """Write a number of markers in two frames, with names of a given length."""
    names = tuple(f"{i:x}".rjust(letters, "m") for i in range(n))
    x = np.random.default_rng(0).normal(size=(2, n, 3))
    return Recording(Path("many.c3d"), Markers(names, np.array([0.0, 0.01]), x))


@pytest.mark.parametrize("n", [1, 255, 256, 600])
def test_more_markers_than_a_byte_counts(tmp_path, n):
    """Their names go on in LABELS2, LABELS3, …; ezc3d agrees."""
    ezc3d = pytest.importorskip("ezc3d")
    path = tmp_path / "many.c3d"
    write_c3d(many(n), path)
    ours, other = read_c3d_file(path), ezc3d.c3d(str(path))
    assert tuple(ours.strings("POINT", "LABELS")) == many(n).markers.names
    assert other["data"]["points"].shape == (4, n, 2)
    assert len(other["parameters"]["POINT"]["LABELS"]["value"]) == min(n, 255)


@pytest.mark.parametrize(("n", "letters"), [(255, 200), (5000, 90), (70_000, 5)])
def test_more_than_the_format_holds_is_refused(tmp_path, n, letters):
    with pytest.raises(FileError, match="too long|too many"):
        write_c3d(many(n, letters), tmp_path / "many.c3d")
    assert not (tmp_path / "many.c3d").exists()


# ------------------------------------------------------------------------- byte by byte


@pytest.mark.parametrize("n", [1, 255, 256, 2000])
def test_more_events_than_a_byte_counts(tmp_path, n):
    events = tuple(GaitEvent(0.1 * k, "rl"[k % 2], "heel_strike") for k in range(n))
    time = np.arange(10 * n + 1) / 100
    positions = np.tile(body(1)[0] / 1000, (len(time), 1, 1))
    markers = Markers(("C7", "RASI", "LASI", "LKNE", "RKNE", "SACR"), time, positions)
    path = tmp_path / "long.c3d"
    write_c3d(Recording(Path("long"), markers=markers, events=events), path)
    found = read_c3d(path).events
    assert [e.side for e in found] == [e.side for e in events]
    np.testing.assert_allclose([e.time for e in found], [e.time for e in events], atol=1e-3)


def body(n_frames: int = 5, n_points: int = 6) -> np.ndarray:
    """An upright body [mm], z up."""
    rng = np.random.default_rng(3)
    return rng.normal(size=(n_frames, n_points, 3)) * 60 + np.linspace(50, 1700, n_points)[
        :, None
    ] * [
        0,
        0,
        1,
    ]


def point_group(names, **more) -> dict:
    """The POINT group."""
    return {"LABELS": list(names), "UNITS": "mm", "X_SCREEN": "+X", "Y_SCREEN": "+Z"} | more


@pytest.mark.parametrize("processor", [INTEL, DEC, MIPS])
@pytest.mark.parametrize("scale", [-0.1, 0.1])
def test_every_processor_and_number_type(tmp_path, processor, scale):
    """The same numbers, whoever wrote them; gaps stay gaps."""
    points = body()
    points[2, 1] = np.nan
    path = tmp_path / "a.c3d"
    parameters = {"POINT": point_group("ABCDEF", RATE=50.0)}
    path.write_bytes(
        build(
            points,
            np.zeros((5, 1, 0)),
            parameters,
            rate=50,
            processor=processor,
            scale=scale,
            first=11,
        )
    )
    recording = read_c3d(path)
    tolerance = 0.6e-3 * scale if scale > 0 else 1e-7
    np.testing.assert_allclose(recording.markers.positions, points / 1e3, atol=tolerance)
    np.testing.assert_allclose(recording.markers.time, 0.2 + np.arange(5) / 50)


def test_analog_scaling(tmp_path):
    """(raw - OFFSET) * SCALE * GEN_SCALE, per channel."""
    raw = np.array([[[10, 20], [30, 40]]] * 5)
    analog = {"SCALE": np.array([2.0, 3.0]), "OFFSET": np.array([1, -2]), "GEN_SCALE": 0.5}
    path = tmp_path / "a.c3d"
    path.write_bytes(
        build(body(), raw, {"POINT": point_group("ABCDEF"), "ANALOG": analog}, scale=0.1)
    )
    file = read_c3d_file(path)
    assert file.analog_rate == 200
    np.testing.assert_allclose(file.analog[:2], [[9.0, 33.0], [29.0, 63.0]])


@pytest.mark.parametrize(
    ("unit", "factor"), [("mm", 1e-3), ("m", 1.0), ("cm", 1e-2), ("in", 0.0254), ("furlong", 1e-3)]
)
def test_units(tmp_path, unit, factor):
    """Metres inside; an unknown unit is judged by the size of the body, and said."""
    path = tmp_path / "a.c3d"
    points = body() * (1e-3 / factor)
    parameters = {"POINT": point_group("ABCDEF", UNITS=unit)}
    path.write_bytes(build(points, np.zeros((5, 1, 0)), parameters))
    recording = read_c3d(path)
    np.testing.assert_allclose(recording.markers.positions, body() / 1e3, atol=1e-6)
    assert bool(recording.warnings) == (unit == "furlong")


@pytest.mark.parametrize("up", ["+z", "+y", "+x", "-z", "-y", "-x"])
@pytest.mark.parametrize("declared", [True, False])
def test_up_axis(tmp_path, up, declared):
    """The body stands along z, whether the file says which axis is up or not."""
    axis, sign = "xyz".index(up[1]), 1 if up[0] == "+" else -1
    points = np.roll(body(), axis - 2, axis=2)
    points[..., axis] *= sign
    group = point_group("ABCDEF", Y_SCREEN=up.upper())
    if not declared:
        del group["X_SCREEN"], group["Y_SCREEN"]
    path = tmp_path / "a.c3d"
    path.write_bytes(build(points, np.zeros((5, 1, 0)), {"POINT": group}))
    z = read_c3d(path).markers.positions[..., 2]
    np.testing.assert_allclose(z, body()[..., 2] / 1e3, atol=1e-6)


def test_labels(tmp_path):
    """LABELS2, LABELS3; a common prefix goes, two people's stay; repeated names are numbered."""
    names = [f"Ann:M{i}" for i in range(600)]
    group = point_group(names[:255]) | {"LABELS2": names[255:510], "LABELS3": names[510:]}
    path = tmp_path / "a.c3d"
    path.write_bytes(build(body(2, 600), np.zeros((2, 1, 0)), {"POINT": group}))
    assert read_c3d(path).markers.names == tuple(f"M{i}" for i in range(600))
    two = ["Ann:A", "Ann:B", "Bob:A", "Bob:B", "Bob:C", "*6"]
    path.write_bytes(build(body(), np.zeros((5, 1, 0)), {"POINT": point_group(two)}))
    recording = read_c3d(path)
    assert recording.markers.names == tuple(two[:5]) and "2 subjects" in " ".join(
        recording.warnings
    )
    twice = ["A", "A", "B", "C", "D", "E"]
    path.write_bytes(build(body(), np.zeros((5, 1, 0)), {"POINT": point_group(twice)}))
    assert read_c3d(path).markers.names == ("A", "A_2", "B", "C", "D", "E")


def test_a_cluster_of_markers_is_no_segment_frame(tmp_path):
    """T0 to T3 are markers unless they stand square on each other like axes."""
    names = ["T0", "T1", "T2", "T3", "HEAD", "HEEL"]
    points = body()
    path = tmp_path / "a.c3d"
    path.write_bytes(build(points, np.zeros((5, 1, 0)), {"POINT": point_group(names)}))
    assert read_c3d(path).markers.names == tuple(names)
    points[:, 1:4] = points[:, :1] + 100 * np.eye(3)
    path.write_bytes(build(points, np.zeros((5, 1, 0)), {"POINT": point_group(names)}))
    recording = read_c3d(path)
    assert recording.markers.names == ("HEAD", "HEEL") and set(recording.outputs) == set(names[:4])


def wrench() -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Force on the body [N], where it acts [m], free moment [N m], depth of the plate [m]."""
    n = 20
    t = np.linspace(0, 1, n)
    force = np.stack([-80 + 160 * t, 20 * np.sin(6 * t), 700 + 50 * t], axis=1)
    cop = np.stack([0.2 + 0.2 * t, 0.15 + 0.05 * t, 0 * t], axis=1)
    return force, cop, 3.0 - 5 * t, 0.045


@pytest.mark.parametrize("kind", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("sense", [-1, 1], ids=["on the plate", "on the body"])
@pytest.mark.parametrize("flipped", [False, True], ids=["origin", "origin flipped"])
@pytest.mark.parametrize("corners", [CORNERS, CORNERS[[1, 2, 3, 0]], CORNERS[::-1]])
def test_plate_types(tmp_path, kind, sense, flipped, corners):
    """Channels computed from a known wrench by each type's rule give that wrench back."""
    force, cop, free, depth = wrench()
    axes, centre = plate_axes(corners), corners.mean(axis=0)
    up = axes[2, 2]
    o = np.array([0.001, -0.002, depth * up])  # transducer to surface, plate axes, out of the plate
    f = sense * force @ axes
    m = sense * (np.cross(cop - centre, force) + free[:, None] * [0, 0, 1]) @ axes
    m0 = m + np.cross(o, f)  # about the transducer
    units = ["N"] * 3 + ["Nmm"] * 3
    cal = np.zeros(0)
    if kind == 1:
        p = (cop - centre) @ axes * 1e3
        tz = m[:, 2] - (p[:, 0] * f[:, 1] - p[:, 1] * f[:, 0]) / 1e3
        channels = np.column_stack([f, p[:, :2], 1e3 * tz])
        units = ["N", "N", "N", "mm", "mm", "Nmm"]
    elif kind in (2, 4):
        channels = np.column_stack([f, 1e3 * m0])
        if kind == 4:
            cal = np.diag([10.0, 10, 10, 500, 500, 500]) + 0.01
            channels = np.linalg.solve(cal, channels.T).T
            cal, units = cal[..., None], ["V"] * 6
    else:
        a, b = 0.12, 0.2
        o = np.array([0.0, 0.0, o[2]])
        m0 = m + np.cross(o, f)
        # Four sensors at (±a, ±b): the rule of type 3 turned round, loads shared evenly.
        dx = (m0[:, 2] / 2) / b
        dy = (m0[:, 2] / 2) / a
        fx12, fx34 = f[:, 0] / 2 - dx / 2, f[:, 0] / 2 + dx / 2
        fy14, fy23 = f[:, 1] / 2 + dy / 2, f[:, 1] / 2 - dy / 2
        mx, my, fz = m0[:, 0] / b / 4, m0[:, 1] / a / 4, f[:, 2] / 4
        z = [fz + mx - my, fz + mx + my, fz - mx + my, fz - mx - my]
        channels = np.column_stack([fx12, fx34, fy14, fy23, *z])
        units = ["N"] * 8
        o = np.array([a, b, o[2]])
        if kind == 5:
            s = np.array(
                [[1, 1, 0, 0, 0, 0, 0, 0], [0, 0, 1, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 1, 1, 1],
                 [0, 0, 0, 0, b, b, -b, -b], [0, 0, 0, 0, -a, a, a, -a], [-b, b, a, -a, 0, 0, 0, 0]]
            )  # fmt: skip
            cal = (s * np.array([1, 1, 1, 1e3, 1e3, 1e3])[:, None])[..., None]
            o = np.array([0.0, 0.0, o[2]])
    n = channels.shape[1]
    group = {
        "USED": np.array([1]), "TYPE": np.array([kind]), "ZERO": np.array([1, 0]),
        "CORNERS": 1e3 * corners.T[..., None],
        "ORIGIN": (1e3 * o * (-1 if flipped and kind in (2, 4) else 1))[:, None],
        "CHANNEL": np.arange(1, n + 1)[:, None], "CAL_MATRIX": cal,
    }  # fmt: skip
    parameters = {
        "POINT": point_group("ABCDEF"),
        "ANALOG": {"UNITS": units, "SCALE": np.ones(n), "OFFSET": np.zeros(n, dtype=int)},
        "FORCE_PLATFORM": group,
    }
    path = tmp_path / "a.c3d"
    path.write_bytes(build(body(), channels.reshape(5, 4, n), parameters))
    recording = read_c3d(path)
    (plate,) = recording.plates
    assert recording.warnings == ()
    np.testing.assert_allclose(plate.force, force, atol=1e-3)
    np.testing.assert_allclose(plate.cop, cop, atol=1e-5)
    np.testing.assert_allclose(plate.free_moment, free, atol=2e-3)
    np.testing.assert_allclose(plate.time, np.arange(20) / 400)


def test_baseline(tmp_path):
    """FORCE_PLATFORM:ZERO names unloaded frames whose mean is no force; a loaded one is refused."""
    force = np.zeros((20, 6))
    force[8:, 2] = -700.0
    force += [3.0, -2.0, 12.0, 500.0, 0.0, 0.0]
    for zero, offset, warned in (([1, 2], 0.0, 0), ([3, 4], -12.0, 1), ([1, 0], -12.0, 0)):
        group = {
            "USED": np.array([1]), "TYPE": np.array([2]), "ZERO": np.array(zero),
            "CORNERS": 1e3 * CORNERS.T[..., None], "ORIGIN": np.array([[0.0], [0.0], [-40.0]]),
            "CHANNEL": np.arange(1, 7)[:, None],
        }  # fmt: skip
        units = {"UNITS": ["N"] * 3 + ["Nmm"] * 3}
        parameters = {"POINT": point_group("ABCDEF"), "ANALOG": units, "FORCE_PLATFORM": group}
        path = tmp_path / "a.c3d"
        path.write_bytes(build(body(), force.reshape(5, 4, 6), parameters))
        recording = read_c3d(path)
        assert recording.plates[0].force[:8, 2] == pytest.approx(offset, abs=1e-3)
        assert recording.plates[0].force[9, 2] == pytest.approx(700 + offset, abs=1e-3)
        assert sum("ZERO" in w for w in recording.warnings) == warned


@pytest.mark.parametrize(
    ("label", "context", "kind", "side"),
    [
        ("Foot Strike", "Left", "heel_strike", "l"),
        ("Foot Off", "Right", "toe_off", "r"),
        ("Heel Strike", "right", "heel_strike", "r"),
        ("RHS", "", "heel_strike", "r"),
        ("LTO", "", "toe_off", "l"),
        ("Left Initial Contact", "", "heel_strike", "l"),
        ("Toe Off R", "", "toe_off", "r"),
        ("Start", "General", None, None),
    ],
)
def test_event_names(label, context, kind, side):
    """The names that programs use."""
    assert event_kind(label) == kind
    if kind:
        assert event_side(label, context) == side


@pytest.mark.parametrize(
    ("value", "height"), [(1740.0, 1.74), (174.0, 1.74), (1.74, 1.74), (17.4, None), (9000.0, None)]
)
def test_body_height(tmp_path, value, height):
    """In mm, cm or m; anything else is ignored with a warning."""
    path = tmp_path / "a.c3d"
    parameters = {"POINT": point_group("ABCDEF"), "PROCESSING": {"Height": value}}
    path.write_bytes(build(body(), np.zeros((5, 1, 0)), parameters))
    recording = read_c3d(path)
    assert recording.subject.height == (pytest.approx(height) if height else None)
    assert bool(recording.warnings) == (height is None)


def test_no_markers_no_c3d(tmp_path):
    """The writer says what it needs."""
    from plantigrade.motion import Recording

    with pytest.raises(FileError, match="no markers"):
        write_c3d(Recording(tmp_path / "x"), tmp_path / "a.c3d")


def test_markers_alone_make_a_round_trip(tmp_path):
    time = np.arange(20) / 100.0
    x = np.random.default_rng(0).normal(size=(20, 3, 3))
    x[4, 1] = np.nan
    write_c3d(Recording(tmp_path / "a.c3d", Markers(("A", "B", "C"), time, x)), tmp_path / "a.c3d")
    again = read_c3d(tmp_path / "a.c3d").markers
    assert again is not None and again.names == ("A", "B", "C")
    np.testing.assert_allclose(again.positions, x, atol=1e-6)
    np.testing.assert_allclose(again.time, time, atol=1e-9)


@pytest.mark.parametrize(
    ("groups", "name", "date"),
    [
        ({"SUBJECTS": {"NAMES": ["HC032A  "], "AGE": 33.0}}, "HC032A", None),
        ({"SUBJECTS": {"NAMES": ["Ann", "Bob"]}}, None, None),  # two people: nobody's
        ({"SUBJECTS": {"NAMES": ["Ann", ""]}}, "Ann", None),
        ({"SUBJECT": {"NAME": ["Ann"]}, "TRIAL": {"DATE": ["2026-05-01"]}}, "Ann", "2026-05-01"),
        ({"SUBJECTS": {"NAMES": [" "]}}, None, None),
        ({}, None, None),
    ],
)
def test_who_it_was_and_when(tmp_path, groups, name, date):
    """Name and date are the file's own words, or not there; they come back when written."""
    path = tmp_path / "a.c3d"
    parameters = {"POINT": point_group("ABCDEF"), **groups}
    path.write_bytes(build(body(), np.zeros((5, 1, 0)), parameters))
    subject = read_c3d(path).subject
    assert (subject.name, subject.date) == (name, date)
    again = tmp_path / "again.c3d"
    write_c3d(read_c3d(path), again)
    assert read_c3d(again).subject == subject
    assert subject.figures.get("subject_name") == name


def test_parameters_that_go_on_beyond_their_count(tmp_path):
    """Some programs count too few blocks of parameters; the data begin where the header says."""
    path = tmp_path / "a.c3d"
    long = {"DESCRIPTIONS": ["described at length " * 12] * 6}
    content = bytearray(build(body(), np.zeros((5, 1, 0)), {"POINT": long | point_group("ABCDEF")}))
    assert content[514] > 1
    content[514] = 1
    path.write_bytes(content)
    assert read_c3d(path).markers.names == tuple("ABCDEF")


def test_channels_counted_without_their_samples(tmp_path):
    """Some programs write the channels where their samples in a frame belong."""
    raw = np.arange(5 * 3 * 2, dtype=float).reshape(5, 3, 2)
    path = tmp_path / "a.c3d"
    groups = {"POINT": point_group("ABCDEF"), "ANALOG": {"USED": 2}}
    content = bytearray(build(body(), raw, groups))
    content[4:6] = (2).to_bytes(2, "little")
    path.write_bytes(content)
    file = read_c3d_file(path)
    np.testing.assert_allclose(file.analog, raw.reshape(-1, 2))
    np.testing.assert_allclose(file.points, body())
