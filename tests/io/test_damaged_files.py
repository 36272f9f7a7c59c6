"""Damaged motion files end in our own error or in a finite motion, never in anything else."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from plantigrade.errors import FileError
from plantigrade.io import read
from plantigrade.io.amc import read_amc
from plantigrade.io.bvh import read_bvh
from plantigrade.io.deepmimic import read_deepmimic
from plantigrade.io.mot import read_mot
from tests.io.test_asf_amc import AMC, LEG
from tests.io.test_bvh import BODY, MOTION

_WORDS = ["nan", "inf", "1e999", "", "-1", "x", "1_0", "9" * 5000, "ü", "٣", "\t", "{", "}", ":"]
_QUAT = "1,0,0,0"
_ROW = f"[0.1,0,0.9,0,{_QUAT},{_QUAT},{_QUAT},{_QUAT},-0.5,{_QUAT},{_QUAT},0.5"
_ROW += f",{_QUAT},-0.5,{_QUAT},{_QUAT},0.5]"

SOURCES = {
    "leg_01.amc": (AMC, read_amc),
    "leg.asf": (LEG, None),
    "body.bvh": (BODY + MOTION, read_bvh),
    "motion.txt": (
        '{"Loop": "wrap",\n"Frames": [\n' + ",\n".join([_ROW] * 3) + "\n]}",
        read_deepmimic,
    ),
    "angles.mot": (
        "a\ninDegrees=yes\nendheader\ntime\tknee_angle_r\tpelvis_ty\n"
        "0\t1\t0.9\n0.1\t2\t0.9\n0.2\t30\t0.9\n",
        read_mot,
    ),
    "force.sto": (
        "a\nnRows=2\nendheader\ntime ground_force_vx ground_force_vy ground_force_vz "
        "ground_force_px ground_force_py ground_force_pz\n"
        "0 1 500 2 0.1 0 0.2\n0.1 1 600 2 0.1 0 0.2\n",
        read_mot,
    ),
}


@st.composite
def damage(draw, text):
    kind = draw(st.integers(0, 6))
    raw = text.encode()
    place = st.integers(0, len(raw) - 1)
    if kind == 0:  # truncated
        return raw[: draw(place)]
    if kind == 1:  # bytes changed
        raw = bytearray(raw)
        for i in draw(st.lists(place, min_size=1, max_size=20)):
            raw[i] = draw(st.integers(0, 255))
        return bytes(raw)
    if kind == 2:  # a piece missing
        i = draw(place)
        return raw[:i] + raw[i + draw(st.integers(1, 80)) :]
    if kind == 3:  # reordered
        return "\n".join(draw(st.permutations(text.split("\n")))).encode()
    if kind == 4:  # a line twice
        lines = text.split("\n")
        lines.insert(draw(st.integers(0, len(lines))), draw(st.sampled_from(lines)))
        return "\n".join(lines).encode()
    if kind == 5:  # a word replaced
        separator = draw(st.sampled_from([" ", "\t", "\n", ","]))
        words = text.split(separator)
        words[draw(st.integers(0, len(words) - 1))] = draw(st.sampled_from(_WORDS))
        return separator.join(words).encode()
    return text.encode(draw(st.sampled_from(["utf-16", "utf-32", "utf-8-sig", "cp037"])))


@pytest.mark.parametrize("name", SOURCES)
@settings(
    max_examples=150,
    deadline=2000,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(content=st.data())
def test_damaged(tmp_path, name, content):
    text, reader = SOURCES[name]
    (tmp_path / "leg.asf").write_text(LEG)
    (tmp_path / "leg_01.amc").write_text(AMC)
    (tmp_path / name).write_bytes(content.draw(damage(text)))
    try:
        recording = read_amc(tmp_path / "leg_01.amc") if reader is None else reader(tmp_path / name)
    except FileError as error:
        assert error.path.parent == tmp_path and error.problem
        return
    if recording.skeleton is not None:
        assert np.isfinite(recording.skeleton.positions).all()
        assert (np.diff(recording.skeleton.time) > 0).all()


TRC = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
    "100\t100\t2\t1\tmm\nFrame#\tTime\tA\t\t\n\t\tX1\tY1\tZ1\n1\t0.0\t1\t2\t3\n2\t0.01\t1\t2\t3\n"
)


@pytest.mark.parametrize("count", ["9" * 5000, "²", "٣"])
@pytest.mark.parametrize(
    ("name", "text", "place"),
    [
        ("a.trc", TRC, "\t2\t1\tmm"),
        ("a.mot", SOURCES["force.sto"][0], "=2\n"),
        ("a.bvh", BODY + MOTION, "CHANNELS 3 "),
    ],
)
def test_counts_that_python_cannot_take(tmp_path, name, text, place, count):
    """Python refuses to turn more than 4300 digits into a number, and a superscript two."""
    assert place in text
    digit = next(c for c in place if c.isdigit())
    (tmp_path / name).write_text(text.replace(place, place.replace(digit, count, 1)))
    try:
        recording = read(tmp_path / name)
    except FileError as error:
        assert error.problem
    else:
        assert recording.markers is not None or recording.plates
