"""The cache: what is kept, what goes first, and whose files are not trusted."""

import os

import pytest

from plantigrade.batched import code_cache

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="no owners of files here")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A cache folder with one file, "one"."""
    monkeypatch.setenv("PLANTIGRADE_CACHE", str(tmp_path))
    code_cache.write("one", b"content")
    return tmp_path / "functions"


def test_what_was_written_is_read():
    assert code_cache.read("one") == b"content"
    assert code_cache.read("two") is None


def test_folder_and_file_are_private(folder):
    (file,) = folder.iterdir()
    assert folder.stat().st_mode & 0o077 == 0 and file.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("what", ["folder", "file"])
@pytest.mark.parametrize("mode", [0o020, 0o002])
def test_what_others_can_write_to_is_not_trusted(folder, what, mode):
    (file,) = folder.iterdir()
    which = {"folder": folder, "file": file}[what]
    before = which.stat().st_mode
    which.chmod(before | mode)
    assert code_cache.read("one") is None
    if what == "folder":
        code_cache.write("two", b"more")
        assert [p.name for p in folder.iterdir()] == [file.name]
    which.chmod(before)
    assert code_cache.read("one") == b"content"


@pytest.mark.parametrize("mode", [0o777, 0o775])
def test_below_a_folder_others_can_write_to_nothing_is_trusted(tmp_path, monkeypatch, mode):
    """A process that may rename the cache may put another folder of this user in its place."""
    home = tmp_path / "home"
    monkeypatch.delenv("PLANTIGRADE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(home / ".cache"))
    code_cache.write("one", b"content")
    assert code_cache.read("one") == b"content"
    for above in (home, home / ".cache", home / ".cache" / "plantigrade"):
        before = above.stat().st_mode
        above.chmod(mode)
        assert code_cache.read("one") is None
        code_cache.write("two", b"more")
        above.chmod(before)
        assert code_cache.read("one") == b"content" and code_cache.read("two") is None


def test_a_sticky_folder_above_is_trusted(tmp_path):
    """Everybody may write to /tmp, nobody rename there what is another's."""
    tmp_path.chmod(0o1777)
    assert code_cache.read("one") == b"content"


def test_through_a_link_the_real_folders_above_count(tmp_path, monkeypatch):
    open_to_all = tmp_path / "open"
    open_to_all.mkdir()
    (tmp_path / "functions").rename(open_to_all / "functions")
    (tmp_path / "link").symlink_to(open_to_all)
    monkeypatch.setenv("PLANTIGRADE_CACHE", str(tmp_path / "link"))
    assert code_cache.read("one") == b"content"
    open_to_all.chmod(0o777)
    assert code_cache.read("one") is None


def test_without_owners_there_is_no_cache(monkeypatch):
    monkeypatch.delattr(os, "getuid")
    code_cache.write("two", b"more")
    assert code_cache.folder() is None and code_cache.read("one") is None


def test_files_of_another_user_are_not_trusted(monkeypatch):
    me = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: me + 1)
    assert code_cache.read("one") is None


def test_a_link_is_not_followed(folder, tmp_path):
    (file,) = folder.iterdir()
    elsewhere = tmp_path / "elsewhere"
    file.rename(elsewhere)
    file.symlink_to(elsewhere)
    assert code_cache.read("one") is None


def test_what_is_no_file_is_not_read(folder):
    (file,) = folder.iterdir()
    file.unlink()
    file.mkdir()
    assert code_cache.read("one") is None
    file.rmdir()
    file.write_bytes(b"")
    assert code_cache.read("one") is None


def test_a_file_is_not_believed_under_another_name(folder):
    (file,) = folder.iterdir()
    other = code_cache.path_of("two")
    assert other is not None
    file.rename(other)
    assert code_cache.read("two") is None


def test_the_least_recently_used_files_go_first(monkeypatch):
    monkeypatch.setattr(code_cache, "MAX_CACHE_SIZE", 1000)
    for k in range(4):
        code_cache.write(str(k), bytes(300))
        code_cache.read("0")
    kept = [k for k in range(4) if code_cache.read(str(k)) is not None]
    assert 3 in kept and len(kept) < 4
