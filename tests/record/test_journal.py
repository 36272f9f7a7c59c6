"""A journal loses nothing but the line that was being written."""

import pytest

from plantigrade.errors import FileError
from plantigrade.record.journal import Journal


def test_a_later_line_of_a_name_replaces_an_earlier_one(tmp_path):
    journal = Journal(tmp_path / "j.jsonl")
    for name, value in (("a", 1), ("b", float("nan")), ("a", "ä\udcff")):
        journal.append({"name": name, "value": value})
    for found in (journal, Journal(tmp_path / "j.jsonl")):
        assert [(line["name"], line["value"]) for line in found] == [("a", "ä\udcff"), ("b", None)]
        assert len(found) == 2 and "a" in found and "c" not in found
        assert [line["name"] for line in found.lines(["b", "c", "a"])] == ["b", "a"]


@pytest.mark.parametrize("torn", [b'{"name": "c", "val', b'{"name": "c"}', b"\0\0\0\n", b'["c"]\n'])
def test_what_was_cut_off_or_damaged_is_passed_over(tmp_path, torn):
    path = tmp_path / "j.jsonl"
    journal = Journal(path)
    journal.append({"name": "a"})
    journal.append({"name": "b"})
    journal.close()
    with path.open("ab") as stream:
        stream.write(torn)
    again = Journal(path)
    assert [line["name"] for line in again] == ["a", "b"]
    again.append({"name": "d"})
    assert [line["name"] for line in Journal(path)] == ["a", "b", "d"]
    assert torn.endswith(b"\n") or torn not in path.read_bytes()


def test_a_journal_that_cannot_be_written_is_named(tmp_path):
    journal = Journal(tmp_path / "nowhere" / "j.jsonl")
    with pytest.raises(FileError, match="cannot be written"):
        journal.append({"name": "a"})
    assert not len(journal)


def test_two_do_not_write_at_once(tmp_path):
    one, other = Journal(tmp_path / "j.jsonl"), Journal(tmp_path / "j.jsonl")
    one.append({"name": "a"})
    for late in (other, Journal(tmp_path / "j.jsonl")):
        with pytest.raises(FileError, match="another process writes"):
            late.append({"name": "b"})
    one.close()
    again = Journal(tmp_path / "j.jsonl")
    again.append({"name": "c"})
    assert [line["name"] for line in again] == ["a", "c"]
