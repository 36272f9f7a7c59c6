"""Every file that was read is in the provenance, under a name that is its own."""

import hashlib

import pytest

from plantigrade.errors import FileError
from plantigrade.record.provenance import source_files


def test_sums_and_names(tmp_path):
    for folder in ("x/a", "y/a", "b"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "walk.c3d").write_bytes(folder.encode())
    static = tmp_path / "static.c3d"
    static.write_bytes(b"")
    walks = [tmp_path / folder / "walk.c3d" for folder in ("x/a", "y/a", "b")]
    assert source_files([*walks, static, static]) == {
        "x/a/walk.c3d": hashlib.sha256(b"x/a").hexdigest(),
        "y/a/walk.c3d": hashlib.sha256(b"y/a").hexdigest(),
        "b/walk.c3d": hashlib.sha256(b"b").hexdigest(),
        "static.c3d": hashlib.sha256(b"").hexdigest(),
    }


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match="gone.c3d: there is no such file"):
        source_files([tmp_path / "gone.c3d"])
