"""Files written whole or not at all."""

import os

import pytest

from plantigrade.errors import FileError
from plantigrade.io.writing import csv_text, whole_file, write_bytes, write_text


def test_a_file_that_could_not_be_completed_stays_as_it_was(tmp_path):
    path = tmp_path / "walk.csv"
    write_text(path, "whole")
    with pytest.raises(RuntimeError), whole_file(path) as part:
        part.write_text("half")
        raise RuntimeError
    assert path.read_text() == "whole" and os.listdir(tmp_path) == ["walk.csv"]


def test_a_full_disk_is_an_error_of_our_own(tmp_path):
    with pytest.raises(FileError, match="cannot be written"), whole_file(tmp_path / "walk.csv"):
        raise OSError(28, "No space left on device")
    assert not os.listdir(tmp_path)


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(FileError, match=r"there is no folder .*runs.* — create it first"):
        write_bytes(tmp_path / "runs" / "walk.npz", b"")


@pytest.mark.skipif(os.name != "posix", reason="links and pipes of POSIX")
def test_a_link_stays_a_link(tmp_path):
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink() and target.read_text() == "new"


def test_what_utf_8_lacks_is_escaped(tmp_path):
    write_text(tmp_path / "a", "a\udcff\n")
    assert (tmp_path / "a").read_bytes() == b"a\\udcff\n"


def test_a_table_has_six_digits_and_empty_fields():
    assert csv_text(["a", "b"], [[1 / 3, None], ["x, y", float("nan")]]) == (
        'a,b\n0.333333,\n"x, y",\n'
    )
