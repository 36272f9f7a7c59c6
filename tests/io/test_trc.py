"""TRC: OpenSim's axes, units, gaps, headers of all kinds."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import convert, read
from plantigrade.io.trc import read_trc, write_trc
from plantigrade.motion import Markers, Recording

HEADER = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
    "OrigNumFrames\n{rate}\t{rate}\t{frames}\t4\t{unit}\t{rate}\t1\t{frames}\n"
    "Frame#\tTime\tHEAD\t\t\tHIP\t\t\tKNEE\t\t\tHEEL\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\tX4\tY4\tZ4\n{blank}"
)
# x forward, y up, z right [m]: the heel is 0.1 to the right, so at y = -0.1 inside
POINTS = np.array([[0.0, 1.7, 0.0], [0.05, 0.9, 0.02], [0.1, 0.5, 0.05], [0.0, 0.05, 0.1]])


def text(points=POINTS, n=3, unit="mm", scale=1e3, blank="\n", rate="100.00", sep="\t") -> str:
    """Return a file of ``n`` frames that move forward."""
    rows = []
    for i in range(n):
        values = (points + [0.01 * i, 0, 0]) * scale
        rows.append(sep.join([str(i + 1), f"{i / 100:.3f}", *(f"{v:.5f}" for v in values.ravel())]))
    return HEADER.format(rate=rate, frames=n, unit=unit, blank=blank) + "\n".join(rows) + "\n"


def write(path: Path, content: str) -> Path:
    """Write a file and return its path."""
    path.write_text(content)
    return path


@pytest.mark.parametrize(("unit", "scale"), [("mm", 1e3), ("cm", 1e2), ("m", 1.0), ("blocks", 1e3)])
@pytest.mark.parametrize("blank", ["", "\n"])
@pytest.mark.parametrize("sep", ["\t", "  "])
def test_axes_and_units(tmp_path, unit, scale, blank, sep):
    """X stays forward, y up becomes z, z right becomes minus y."""
    path = write(tmp_path / "a.trc", text(unit=unit, scale=scale, blank=blank, sep=sep))
    recording = read_trc(path)
    assert recording.markers.names == ("HEAD", "HIP", "KNEE", "HEEL")
    np.testing.assert_allclose(recording.markers.positions[0, 0], [0, 0, 1.7], atol=1e-7)
    np.testing.assert_allclose(recording.markers.positions[2, 3], [0.02, -0.1, 0.05], atol=1e-7)
    np.testing.assert_allclose(recording.markers.time, [0, 0.01, 0.02])
    assert bool(recording.warnings) == (unit == "blocks")


def test_z_up_is_seen(tmp_path):
    """A body that stands along z does so in a file whose z is up."""
    points = POINTS[:, [0, 2, 1]]
    recording = read_trc(write(tmp_path / "a.trc", text(points)))
    np.testing.assert_allclose(recording.markers.positions[0], points, atol=1e-7)
    assert "+z" in recording.warnings[0]


@pytest.mark.parametrize(
    "gap",
    ["\t\t", "NaN\tNaN\tNaN", "0.0\t0.0\t0.0", "nan\t\t1.0"],
    ids=["blank", "NaN", "0", "one"],
)
def test_gaps(tmp_path, gap):
    """Blank, NaN and 0 0 0 are gaps of that marker and frame only."""
    lines = text().split("\n")
    fields = lines[7].split("\t")
    lines[7] = "\t".join(fields[:5] + gap.split("\t") + fields[8:])
    markers = read_trc(write(tmp_path / "a.trc", "\n".join(lines))).markers
    missing = np.isnan(markers.positions)
    assert missing[1, 1].all() and missing.sum() == 3


def test_gaps_at_the_end_of_a_row(tmp_path):
    """Programs leave trailing fields out altogether."""
    lines = text().split("\n")
    lines[7] = "\t".join(lines[7].split("\t")[:8])
    missing = np.isnan(read_trc(write(tmp_path / "a.trc", "\n".join(lines))).markers.positions)
    assert missing[1, 2:].all() and missing.sum() == 6


def test_decimal_commas(tmp_path):
    """As a computer set to German exports it."""
    head, rows = text().split("\n\n")
    path = write(tmp_path / "a.trc", head + "\n\n" + rows.replace(".", ","))
    np.testing.assert_allclose(read_trc(path).markers.positions[0, 0], [0, 0, 1.7], atol=1e-7)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda t: t.replace("Frame#", "Frams"), "starts with 'Frame#  Time'"),
        (lambda t: t.split("\n\n")[0], "no frames"),
        (lambda t: t.replace("0.020", "0.005"), "line 9: .*time must increase"),
        (lambda t: t.replace("1700.00000", "1.7.0", 1), r"line 7, field 4 \(HEAD y\): '1.7.0'"),
        (lambda t: t.replace("\n2\t", "\n2\t7\t"), "line 8: this row has 15 fields where 14"),
    ],
)
def test_errors_name_the_line(tmp_path, change, match):
    """File, line, field, remedy."""
    with pytest.raises(FileError, match=match) as caught:
        read_trc(write(tmp_path / "a.trc", change(text())))
    assert caught.value.remedy and "a.trc" in str(caught.value)


def test_labels_that_occur_again_are_numbered(tmp_path):
    twice = text().replace("\tHIP\t", "\tHEAD\t")
    recording = read_trc(write(tmp_path / "a.trc", twice))
    assert recording.markers.names[:1] == ("HEAD",) and "HEAD_2" in recording.markers.names
    assert recording.warnings == ("repeated labels were numbered: HEAD",)


def test_unusual_contents_are_noted(tmp_path):
    """Fewer frames than announced; a last row cut off."""
    recording = read_trc(write(tmp_path / "a.trc", text().replace("\t3\t4\tmm", "\t9\t4\tmm")))
    assert recording.warnings == ("the header announces 9 frames, the file holds 3",)
    recording = read_trc(write(tmp_path / "a.trc", text()[:-30]))
    assert len(recording.markers.time) == 2 and "truncated" in recording.warnings[0]


@pytest.mark.parametrize(
    "name",
    ["rajagopal_walk/markers_walk", "gait2392_subject01/subject01_walk1",
     "gait2392_subject01/subject01_static"],
)  # fmt: skip
def test_recordings_and_round_trip(data, tmp_path, name):
    """People of human size stand on the floor; written and read back to 1e-8 m."""
    once = read_trc(data / "opensim" / f"{name}.trc")
    z = once.markers.positions[..., 2]
    assert -0.02 < np.nanmin(z) < 0.1 and 1.3 < np.nanmax(z) < 2
    write_trc(once, tmp_path / "b.trc")
    again = read_trc(tmp_path / "b.trc")
    assert again.markers.names == once.markers.names
    np.testing.assert_allclose(again.markers.positions, once.markers.positions, atol=1e-8)
    np.testing.assert_allclose(again.markers.time, once.markers.time, atol=1e-9)


def test_left_and_right_stay(data):
    """Turning axes mirrors nothing: walking along +x, the right hip is at smaller y."""
    markers = read(data / "opensim" / "rajagopal_walk" / "markers_walk.trc").markers
    right, left = (markers.positions[:, markers.index(n)] for n in ("R.ASIS", "L.ASIS"))
    assert (right[-1] - right[0])[0] > 1 and (right[:, 1] < left[:, 1]).all()


def test_gaps_survive_writing(tmp_path):
    """NaN is an empty field."""
    positions = np.tile(POINTS[:, [0, 2, 1]], (4, 1, 1))
    positions[1, 2] = np.nan
    markers = Markers(("A", "B", "C", "D"), np.arange(4) / 50, positions)
    write_trc(Recording(Path("x"), markers), tmp_path / "a.trc")
    again = read_trc(tmp_path / "a.trc")
    np.testing.assert_allclose(again.markers.positions, positions, atol=1e-8)
    bad = replace(markers, names=("A\tB", "B", "C", "D"))
    with pytest.raises(FileError, match="not allowed in a TRC header"):
        write_trc(Recording(Path("x"), bad), tmp_path / "a.trc")


def test_convert_c3d_to_trc(data, tmp_path):
    """Markers go to the TRC, plates into a MOT beside it, and what is lost is said."""
    source = data / "c3d" / "HC032A03.c3d"
    notes = " ".join(convert(source, tmp_path / "a.trc"))
    assert "a_grf.mot" in notes and "gait events" in notes and "model outputs" in notes
    once, again = read(source), read(tmp_path / "a.trc")
    np.testing.assert_allclose(again.markers.positions, once.markers.positions, atol=1e-8)
    plates = read(tmp_path / "a_grf.mot").plates
    for new, old in zip(plates, once.plates, strict=True):
        np.testing.assert_allclose(new.force, old.force, atol=1e-4)


def test_convert_what_cannot_be(data, tmp_path):
    """A target that cannot hold the source: one sentence, nothing written."""
    with pytest.raises(FileError, match="TRC files store markers; .* has coordinates"):
        convert(data / "opensim" / "rajagopal_walk" / "coordinates.sto", tmp_path / "a.trc")
    with pytest.raises(FileError, match="'.amc' cannot be written"):
        convert(data / "opensim" / "rajagopal_walk" / "markers_walk.trc", tmp_path / "a.amc")
    assert not list(tmp_path.iterdir())


def test_trajectories_without_a_name_are_left_out(tmp_path):
    """They follow the named ones, as many as are seen in a frame."""
    lines = text().replace("\t3\t4\tmm", "\t3\t6\tmm").split("\n")
    lines[6] += "\t1.0\t2.0\t3.0"
    lines[8] += "\t1.0\t2.0\t3.0\t4.0\t5.0\t6.0"
    recording = read_trc(write(tmp_path / "a.trc", "\n".join(lines)))
    plain = read_trc(write(tmp_path / "b.trc", text()))
    np.testing.assert_array_equal(recording.markers.positions, plain.markers.positions)
    assert recording.warnings == ("the header announces 6 markers, the file holds 4",)
