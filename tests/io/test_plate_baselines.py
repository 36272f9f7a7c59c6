"""A plate that was not set to zero: what it shows while nobody stands on it goes, and is said."""

import numpy as np
import pytest

from plantigrade.io import read


def test_a_plate_of_a_c3d_file_is_set_to_zero(data):
    """Its plates read -14 and -20 N with nothing on them, and the file names no frames as empty."""
    recording = read(data / "c3d" / "opensim_walking2.c3d")
    said = [w for w in recording.warnings if "baseline" in w]
    assert len(said) == 2 and "-14 N" in said[0] and "-20 N" in said[1]
    for plate in recording.plates:
        vertical = plate.force[:, 2]
        assert abs(np.median(vertical[np.abs(vertical) < 30])) < 0.5
    assert not [w for w in read(data / "c3d" / "HC038A11.c3d").warnings if "baseline" in w]


def test_a_baseline_given_to_a_table_is_taken_from_it(data, tmp_path):
    path = data / "opensim" / "running_subject04" / "run200_grf.mot"
    lines = path.read_text().splitlines()
    start = lines.index("endheader") + 1
    names = lines[start].split("\t")
    columns = [i for i, name in enumerate(names) if name.endswith("force_vy")]
    for n in range(start + 1, len(lines)):
        cells = lines[n].split("\t")
        for i in columns:
            cells[i] = f"{float(cells[i]) - 15:.6f}"
        lines[n] = "\t".join(cells)
    damaged = tmp_path / "run200_grf.mot"
    damaged.write_text("\n".join(lines))
    good, mended = read(path), read(damaged)
    assert sum("without load is -15 N" in w for w in mended.warnings) == 2
    for a, b in zip(good.plates, mended.plates, strict=True):
        assert b.force[:, 2] == pytest.approx(a.force[:, 2], abs=0.01)
        loaded = a.force[:, 2] > 50
        np.testing.assert_allclose(b.cop[loaded], a.cop[loaded], atol=5e-3)


def test_feet_of_a_sitting_person_are_no_baseline(data):
    for name in ("STS1", "squats1", "static1", "DJ1"):
        recording = read(data / "opensim" / "opencap_subject4" / f"{name}_grf.mot")
        assert not [w for w in recording.warnings if "baseline" in w]
