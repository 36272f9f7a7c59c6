"""``plantigrade data get``: whole files or none, whatever the network does."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import plantigrade as pg
from plantigrade.commands.main import main
from plantigrade.datasets import data_sets, registry, transfer
from tests.datasets.server import Fault, address, serving
from tests.datasets.server import registry as registry_of

WALK = bytes(range(256)) * 1200  # several chunks
RUN = b"run" * 1000
FILES = {"LICENSES/MIT_lab.txt": b"MIT License", "walks/a walk.c3d": WALK, "walks/run.c3d": RUN}
SETS = {"walks": FILES, "jumps": {"LICENSES/MIT_lab.txt": b"MIT License", "jumps/j.c3d": b"jump"}}
PLACE, PART = Path("data/walks/a walk.c3d"), Path("data/walks/a walk.c3d.part")
AT = address("walks", "walks/a walk.c3d")


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A mirror of two small sets that is asked by default, from an empty folder."""
    (tmp_path / "registry.toml").write_text(registry_of(SETS))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setattr(registry, "REGISTRY", tmp_path / "registry.toml")
    monkeypatch.setattr(transfer, "PAUSE_S", 0.0)
    served = {address(name, to): body for name, files in SETS.items() for to, body in files.items()}
    with serving(served) as server:
        monkeypatch.setenv("PLANTIGRADE_MIRROR", server.base)
        yield server


def contents(folder: str = "data") -> dict[str, bytes]:
    """Return every file below a folder with its bytes."""
    paths = sorted(path for path in Path(folder).rglob("*") if not path.is_dir())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def test_a_set_arrives_whole_with_its_licence_and_is_not_requested_again(server, capsys):
    assert main(["data", "get", "walks"]) == 0
    out, err = capsys.readouterr()
    assert contents() == FILES
    assert err.index("licence  MIT") < err.index("source   https://github.com/lab/walks/tree/0000")
    assert err.index("source") < err.index("walks/a walk.c3d: 307.2 kB, ")
    assert out.splitlines()[0] == "data/walks: walks, 3 files, 0.3 MB (3 downloaded)"
    server.asked.clear()
    assert main(["data", "get", "walks"]) == 0
    assert "(0 downloaded)" in capsys.readouterr().out
    assert server.asked == [] and contents() == FILES


def test_what_was_brought_by_hand_needs_no_network(server, monkeypatch):
    for to, body in FILES.items():
        (Path("mine") / to).parent.mkdir(parents=True, exist_ok=True)
        (Path("mine") / to).write_bytes(body)
    monkeypatch.setenv("PLANTIGRADE_MIRROR", "http://127.0.0.1:1")
    assert main(["data", "get", "walks", "--to", "mine"]) == 0


BROKEN = {
    "cut off": [Fault(stop=100_000)],
    "cut off twice": [Fault(stop=100_000), Fault(stop=100_000)],
    "cut off, and no parts are sent": [Fault(stop=100_000), Fault(ranges=False)],
    "cut off, and another part is sent": [Fault(stop=100_000), Fault(shift=5)],
    "cut off, and no such range": [Fault(stop=100_000), Fault(status=416)],
    "cut off at once": [Fault(stop=0)],
    "wrong contents once": [Fault(body=WALK[::-1])],
    "wrong contents, then cut off": [Fault(body=WALK[::-1]), Fault(stop=7)],
    "too short": [Fault(body=WALK[:-1])],
    "busy": [Fault(status=503), Fault(status=500), Fault(status=429)],
}


@pytest.mark.parametrize("faults", BROKEN.values(), ids=BROKEN)
def test_a_broken_transfer_ends_in_the_exact_bytes(server, faults):
    server.faults[AT] = list(faults)
    assert main(["data", "get", "walks", "--quiet"]) == 0
    assert contents() == FILES


def test_a_cut_transfer_is_continued_and_not_repeated(server):
    server.faults[AT] = [Fault(stop=100_000)]
    assert main(["data", "get", "walks", "--quiet"]) == 0
    assert [asked for path, asked in server.asked if path == AT] == [None, "bytes=100000-"]


def test_too_long_contents_are_not_read_to_the_end(server):
    server.faults[AT] = [Fault(body=WALK + bytes(10**6))]
    assert main(["data", "get", "walks", "--quiet"]) == 0
    assert contents() == FILES and len(server.asked) == len(FILES)


HOPELESS = {
    "wrong contents": (Fault(body=WALK[::-1]), "SHA-256 differs", 5),
    "wrong contents, too long": (Fault(body=WALK[::-1] + b"more"), "SHA-256 differs", 5),
    "always busy": (Fault(status=503), "503", 5),
    "always cut off at once": (Fault(stop=0), "ended after 0 of 307200 bytes", 5),
    "not there": (Fault(status=404), "404", 1),
    "forbidden": (Fault(status=403), "403", 1),
    "to a file": (Fault(location="file:///etc/passwd"), "to what is not HTTPS", 1),
    "to another protocol": (Fault(location="ftp://127.0.0.1/a"), "to what is not HTTPS", 1),
    "to plain http": (Fault(location="http://example.org/a"), "to what is not HTTPS", 1),
    "to no address": (Fault(location="http://["), "the address cannot be used", 1),
    "in a circle": (Fault(location=AT.replace(" ", "%20")), "redirects in a circle", 5),
}


@pytest.mark.parametrize(("fault", "words", "n_asked"), HOPELESS.values(), ids=HOPELESS)
def test_what_never_arrives_leaves_nothing(server, capsys, fault, words, n_asked):
    server.faults[AT] = [fault] * 99
    assert main(["data", "get", "walks"]) == 2
    said = capsys.readouterr().err
    error = said[said.index("error: ") :]
    assert words in error and "2 of 3 files are in data" in error and "--addresses" in error
    assert len(error) < 420
    assert contents() == {to: body for to, body in FILES.items() if "a walk" not in to}
    assert sum(path == AT for path, _ in server.asked) == n_asked


def test_what_arrived_before_is_kept_for_the_next_time(server):
    server.faults[AT] = [Fault(stop=1000)] * 5
    assert main(["data", "get", "walks", "--quiet"]) == 2
    assert PART.read_bytes() == WALK[:5000] and not PLACE.exists()
    server.asked.clear()
    assert main(["data", "get", "walks", "--quiet"]) == 0
    assert server.asked == [(AT, "bytes=5000-")] and contents() == FILES


@pytest.mark.parametrize(
    "there", [WALK, WALK[:-1], WALK + b"more", WALK[::-1], b"other contents", b""],
    ids=["whole", "nearly whole", "too long", "wrong", "wrong beginning", "empty"],
)  # fmt: skip
def test_a_part_that_was_left_there(server, there):
    PART.parent.mkdir(parents=True)
    PART.write_bytes(there)
    assert main(["data", "get", "walks", "--quiet"]) == 0
    assert contents() == FILES


def test_a_foreign_file_is_replaced_only_on_request(server, capsys):
    PLACE.parent.mkdir(parents=True)
    PLACE.write_bytes(b"my own")
    assert main(["data", "get", "walks"]) == 2
    assert "a walk.c3d: exists, and is not the file of the data set" in capsys.readouterr().err
    assert contents() == {"walks/a walk.c3d": b"my own"} and server.asked == []
    assert main(["data", "get", "walks", "--overwrite"]) == 0
    assert contents() == FILES


def test_what_is_no_ordinary_file_is_never_replaced(server, tmp_path, capsys):
    PLACE.mkdir(parents=True)
    assert main(["data", "get", "walks", "--overwrite"]) == 2
    PLACE.rmdir()
    (tmp_path / "elsewhere").write_bytes(b"my own")
    PART.symlink_to(tmp_path / "elsewhere")
    assert main(["data", "get", "walks"]) == 2
    assert "a walk.c3d.part: is not a regular file" in capsys.readouterr().err
    assert (tmp_path / "elsewhere").read_bytes() == b"my own"


def test_no_network(server, monkeypatch, capsys):
    monkeypatch.setenv("PLANTIGRADE_MIRROR", "http://127.0.0.1:1")  # nobody listens
    assert main(["data", "get", "walks"]) == 2
    said = capsys.readouterr().err
    assert "127.0.0.1 cannot be reached (Connection refused); 0 of 3 files are in data" in said
    assert not Path("data").exists()


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl to make a certificate")
def test_an_untrusted_certificate_is_refused(server, tmp_path, capsys):
    files = tmp_path / "certificate.pem", tmp_path / "key.pem"
    made = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
    made += ["-nodes", "-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1"]
    made += ["-out", str(files[0]), "-keyout", str(files[1])]
    subprocess.run(made, check=True, capture_output=True)
    with serving(server.files, files) as other:
        assert main(["data", "get", "walks", "--mirror", other.base]) == 2
        assert "the certificate of 127.0.0.1 cannot be verified" in capsys.readouterr().err
        assert other.asked == [] and not Path("data").exists()


def test_a_name_that_does_not_exist(server, capsys):
    assert main(["data", "get", "wlaks"]) == 2
    assert "no data set 'wlaks'; did you mean walks?" in capsys.readouterr().err
    assert main(["data", "get", "walks", "wlaks"]) == 2
    assert server.asked == [] and not Path("data").exists()


@pytest.mark.parametrize(
    "mirror",
    ["http://example.org", "file:///srv", "ftp://example.org", "example.org", "https://",
     "https://me:secret@example.org", "https://example.org/?a", "https://example.org:port"],
)  # fmt: skip
def test_a_mirror_without_tls_is_refused(server, mirror, capsys):
    assert main(["data", "get", "walks", "--mirror", mirror]) == 2
    assert "the mirror must be an address such as https://" in capsys.readouterr().err


def test_nothing_is_asked_without_a_name(server, capsys):
    assert main(["data", "get"]) == 0
    first, walks, about, *_ = capsys.readouterr().out.splitlines()
    assert first.split() == ["name", "files", "MB", "licence", "good", "for"]
    assert walks.split() == ["walks", "3", "0.3", "MIT", "tests"] and about.strip() == "Two walks"
    assert main(["data", "get", "walks", "--addresses"]) == 0
    assert (
        f"{server.base}{AT.replace(' ', '%20')}  data/walks/a walk.c3d" in capsys.readouterr().out
    )
    assert server.asked == [] and not Path("data").exists()


def test_json(server, capsys):
    assert main(["data", "get", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [each["name"] for each in listed["sets"]] == ["walks", "jumps"]
    assert main(["data", "get", "--all", "--json"]) == 0
    got = json.loads(capsys.readouterr().out)
    assert got["status"] == "ok" and got["folder"] == "data"
    assert [(s["name"], s["licence"], s["n_downloaded"]) for s in got["sets"]] == [
        ("walks", "MIT", 3), ("jumps", "MIT", 1)
    ]  # fmt: skip
    assert contents() == FILES | SETS["jumps"]


def test_all_takes_no_names(server, capsys):
    assert main(["data", "get", "walks", "--all"]) == 2
    assert "--all takes no names" in capsys.readouterr().err


def test_from_python(server):
    folder = pg.get_data("walks", "mine")
    assert folder == Path("mine/walks") and contents("mine") == FILES
    with pytest.raises(pg.PlantigradeError, match="no data set 'runs'"):
        pg.get_data("runs")


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(("sign", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_keeps_what_has_arrived(tmp_path, monkeypatch, sign, code):
    """The signal comes when more has been sent than the buffers between the processes hold."""
    n_sent, files = 16 * 2**20, {"LICENSES/MIT.txt": b"MIT", "big/a.c3d": bytes(18 * 2**20)}
    (tmp_path / "registry.toml").write_text(registry_of({"big": files}))
    program = f"""
import signal, sys
from pathlib import Path
from plantigrade.commands.main import main
from plantigrade.datasets import registry
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever the shell has set
registry.REGISTRY = Path({str(tmp_path / "registry.toml")!r})
sys.exit(main(["data", "get", "big", "--to", {str(tmp_path)!r}]))
"""
    clients, started = [], threading.Event()

    def end() -> None:
        started.wait()
        clients[0].send_signal(sign)

    with serving({address("big", to): body for to, body in files.items()}) as server:
        server.faults[address("big", "big/a.c3d")] = [Fault(stop=n_sent, then=end)]
        monkeypatch.setenv("PLANTIGRADE_MIRROR", server.base)
        command = [sys.executable, "-c", program]
        clients.append(subprocess.Popen(command, stderr=subprocess.PIPE, text=True))
        started.set()
        _, said = clients[0].communicate()
        assert clients[0].returncode == code, said
        assert "what has arrived is kept; the same command continues" in said
        kept = (tmp_path / "big/a.c3d.part").stat().st_size
        assert 0 < kept <= n_sent and not (tmp_path / "big/a.c3d").exists()
        monkeypatch.setattr(registry, "REGISTRY", tmp_path / "registry.toml")
        pg.get_data("big", tmp_path)
    assert server.asked[-1] == (address("big", "big/a.c3d"), f"bytes={kept}-")
    assert contents(str(tmp_path / "big")) == {"a.c3d": files["big/a.c3d"]}


def test_the_registry_is_sane():
    sets = data_sets()
    places: dict[str, tuple[int, str]] = {}
    for name, each in sets.items():
        assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name)
        assert each.about and each.use and each.licence and each.cite
        assert set(each.terms) <= {file.to for file in each.files} and each.terms
        assert all(page.startswith("https://github.com/") for page in each.pages)
        for file in each.files:
            parts = Path(file.to).parts
            assert not Path(file.to).is_absolute() and ".." not in parts and "\\" not in file.to
            assert file.to in each.terms or file.to.startswith(f"{each.folder}/")
            assert re.fullmatch(r"[0-9a-f]{64}", file.sha256) and 0 < file.n_bytes < 10**7
            assert re.fullmatch(
                r"https://raw\.githubusercontent\.com/[\w.-]+/[\w.-]+/[0-9a-f]{40}/[\w./%-]+",
                file.url(),
            )
            assert places.setdefault(file.to, (file.n_bytes, file.sha256)) == (
                file.n_bytes,
                file.sha256,
            ), f"{file.to} is two files"
    assert len(sets) >= 15 and len(places) > 100


def test_the_registered_checksums_are_those_of_the_recordings(data):
    compared = 0
    for each in data_sets().values():
        for file in each.files:
            if (data / file.to).is_file():
                assert transfer.is_right(data / file.to, file), file.to
                compared += 1
    assert compared


def test_a_real_set_through_a_mirror(data, tmp_path, monkeypatch):
    files = data_sets()["deepmimic"].files
    if not all((data / file.to).is_file() for file in files):
        pytest.skip("the folder of recordings lacks the DeepMimic set")
    with serving({file.address: (data / file.to).read_bytes() for file in files}) as mirror:
        folder = pg.get_data("deepmimic", tmp_path, mirror=mirror.base)
    assert pg.read(folder / "humanoid3d_walk.txt").skeleton is not None
