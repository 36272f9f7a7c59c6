"""Tables of markers and coordinates."""

from pathlib import Path

import numpy as np
import pytest

from plantigrade.errors import FileError, UnsupportedFormat
from plantigrade.io import read
from plantigrade.io.csv import read_csv, write_csv
from plantigrade.motion import Markers, Recording, Table

BODY = np.array([[0.0, 0.1, 1.7], [0.1, 0.0, 1.0], [0.0, 0.2, 0.5], [0.1, 0.1, 0.05]])
HEAD = "time," + ",".join(f"{name}_{axis}" for name in "ABCD" for axis in "xyz")


def table(points=BODY, n=4, scale=1.0, head=HEAD) -> str:
    """Return a table of ``n`` equal frames."""
    row = ",".join(f"{v:.6f}" for v in (points * scale).ravel())
    return head + "\n" + "".join(f"{i / 50},{row}\n" for i in range(n))


def write(path: Path, content: str, **how) -> Path:
    """Write a file and return its path."""
    path.write_text(content, **how)
    return path


def test_markers(tmp_path):
    """NAME_x, NAME_y, NAME_z in metres, z up."""
    recording = read_csv(write(tmp_path / "a.csv", table()))
    assert recording.markers.names == tuple("ABCD") and recording.warnings == ()
    np.testing.assert_allclose(recording.markers.positions[2], BODY)


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace(",", ";"),
        lambda t: t.replace(",", "\t"),
        lambda t: t.replace(",", ";").replace(".", ","),
        lambda t: t.replace(",", " , "),
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("_x", ".X").replace("_y", ".Y").replace("_z", ".Z"),
        lambda t: t.replace("time", "Time (s)"),
        lambda t: "# made by hand\n\n" + t,
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le"])
def test_dialects(tmp_path, change, encoding):
    """Separators, decimal commas, line ends, spellings, encodings."""
    path = write(tmp_path / "a.csv", change(table()), encoding=encoding)
    recording = read(path)
    np.testing.assert_allclose(recording.markers.positions[0], BODY)


def test_declared_and_guessed_axes_and_units(tmp_path):
    """Comments on top decide; without them the body does, and it is said."""
    y_up = BODY[:, [0, 2, 1]] * [1, 1, -1]
    said = "# unit: mm\n# up: y\n" + table(y_up, scale=1e3)
    recording = read_csv(write(tmp_path / "a.csv", said))
    np.testing.assert_allclose(recording.markers.positions[0], BODY)
    assert recording.warnings == ()
    recording = read_csv(write(tmp_path / "a.csv", table(y_up, scale=1e3)))
    np.testing.assert_allclose(recording.markers.positions[0], BODY)
    assert len(recording.warnings) == 2
    with pytest.raises(FileError, match="unit 'parsec' is unknown"):
        read_csv(write(tmp_path / "a.csv", "# unit: parsec\n" + table()))


def test_coordinates(tmp_path):
    """Radians, or degrees where the table says so; translations are never angles."""
    content = "time,hip_flexion_r,pelvis_tx\n0,30,0.5\n0.1,60,0.6\n"
    recording = read_csv(write(tmp_path / "a.csv", "# angles: degrees\n" + content))
    np.testing.assert_allclose(recording.coordinates["hip_flexion_r"], np.deg2rad([30, 60]))
    np.testing.assert_allclose(recording.coordinates["pelvis_tx"], [0.5, 0.6])
    assert "degrees" in read_csv(write(tmp_path / "a.csv", content)).warnings[0]


def test_round_trip(tmp_path):
    """Markers with gaps and coordinates, to nine digits."""
    rng = np.random.default_rng(0)
    time = 3.2 + np.arange(50) / 120
    positions = BODY + rng.normal(size=(50, 4, 3)) * 0.01
    positions[7, 1] = np.nan
    once = Recording(
        Path("x"),
        Markers(("A", "B", 'odd, "name"', "D"), time, positions),
        coordinates=Table(("hip_flexion_r", "pelvis_tx"), time, rng.normal(size=(50, 2))),
    )
    write_csv(once, tmp_path / "a.csv")
    again = read_csv(tmp_path / "a.csv")
    assert again.markers.names[:2] == ("A", "B") and again.warnings == ()
    np.testing.assert_allclose(again.markers.positions, positions, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(again.coordinates.values, once.coordinates.values, rtol=1e-8)
    np.testing.assert_allclose(again.markers.time, time, rtol=1e-8)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        ("a,b\n1,2\n", "line 1: no column 'time'"),
        ("time,a,a\n0,1,2\n", "'a' occurs more than once"),
        ("time,a\n", "no rows"),
        ("time,a\n0,1\n0,2\n", "line 3: .*time must increase"),
        ("time,a\n0,1\n1,x\n", r"line 3, field 2 \(a\): 'x' is not a number"),
        ("time,a\n0,1\n1,2,3\n", "line 3: this row has 3 fields where 2"),
        ("0,1,2\n1,2,3\n", "numbers instead of column names"),
        ("# only\n# words\n", "only comments"),
    ],
)
def test_errors_name_the_line(tmp_path, content, match):
    """File, line, field, remedy."""
    with pytest.raises(FileError, match=match) as caught:
        read_csv(write(tmp_path / "a.csv", content))
    assert caught.value.remedy


def test_a_text_that_is_no_table(tmp_path):
    """A letter is no recording."""
    with pytest.raises(UnsupportedFormat, match="time"):
        read(write(tmp_path / "a.txt", "Dear reader,\nthis, is, not a table\n"))


def test_labels_of_markers_that_occur_again_are_numbered(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,A_x,A_y,A_z,A_x,A_y,A_z\n0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n")
    found = read_csv(path)
    assert found.markers.names == ("A", "A_2")
    np.testing.assert_allclose(found.markers.positions[0, 1], [4, 5, 6])
    assert "repeated labels were numbered: A" in found.warnings
