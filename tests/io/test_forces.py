"""Force tables of Motion Analysis."""

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import read
from plantigrade.io.companions import find_companions
from plantigrade.io.forces import read_forces
from tests.io.test_companions import walking

HEAD = "[Force Data]\nNumberOfForcePlates={}\nSampleRate={}\nNumberOfSamples={}\n#Sample"


def write(path, rows, *, rate=1000, plates=2, header=None):
    """Write samples (n, 7 plates)."""
    names = "".join(f"\t{c}{i + 1}" for i in range(plates) for c in "FX FY FZ X Y Z MZ".split())
    head = (header or HEAD).format(plates, f"{rate:.6f}", len(rows)) + names
    body = "\n".join(
        f"{i + 1}\t" + "\t".join(f"{v:.2f}" for v in row) for i, row in enumerate(rows)
    )
    path.write_text(head + "\n" + body + "\n")
    return path


def standing(n=1200, *, up=2, sign=1.0):
    """One foot on the first plate, 0.5 m ahead and 0.2 m to the left; the second is empty."""
    force, point = np.array([10.0, 20.0, 700.0]), np.array([500.0, 200.0, 0.0])
    if up == 1:  # x forward, y up, z to the right
        force, point = force[[0, 2, 1]] * [1, 1, -1], point[[0, 2, 1]] * [1, 1, -1]
    return np.tile([*(sign * force), *point, sign * 3000.0, *np.zeros(7)], (n, 1))


@pytest.mark.parametrize("up", [2, 1])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_units_axes_and_direction(tmp_path, up, sign):
    """N, m, N m; the vertical is that of the force; what pushes the plate pushes back."""
    found = read_forces(write(tmp_path / "walk.forces", standing(20, up=up, sign=sign)))
    one, empty = found.plates
    np.testing.assert_allclose(one.time, np.arange(20) / 1000)
    np.testing.assert_allclose(one.force[3], [10, 20, 700], atol=1e-9)
    np.testing.assert_allclose(one.cop[3], [0.5, 0.2, 0.0], atol=1e-9)
    assert one.free_moment[3] == pytest.approx(3.0)
    assert np.isnan(empty.cop).all() and not empty.force.any()
    assert ("reversed" in " ".join(found.warnings)) == (sign < 0)


def test_it_is_known_by_content_and_found_next_to_the_markers(tmp_path):
    walk = read(walking(tmp_path / "walk_1.trc"))
    write(tmp_path / "walk_1.forces", standing())
    write(tmp_path / "walk_2.forces", standing())
    found = find_companions(walk, read)
    assert found.forces_source == tmp_path / "walk_1.forces" and len(found.forces) == 2


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda t: t.replace("FX1", "AX1").replace("FX2", "AX2"), "names the columns"),
        (lambda t: t.replace("SampleRate=1000.000000", "SampleRate=fast"), "not a number"),
        (lambda t: t.replace("SampleRate=1000.000000", "SampleRate=0"), "0 Hz"),
        (lambda t: t.split("MZ2")[0] + "MZ2\n", "no samples"),
        (lambda t: t.replace("700.00", "7o0", 1), "line 6"),
    ],
)
def test_errors_say_where(tmp_path, change, match):
    path = write(tmp_path / "walk.forces", standing(5))
    path.write_text(change(path.read_text()))
    with pytest.raises(FileError, match=match):
        read(path)


def test_a_row_cut_off_is_left_out(tmp_path):
    path = write(tmp_path / "walk.forces", standing(5))
    path.write_text(path.read_text()[:-30])
    found = read(path)
    assert len(found.plates[0].time) == 4 and "truncated" in found.warnings[0]
