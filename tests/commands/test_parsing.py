"""What the parser takes and refuses, in words; completion in a shell."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from plantigrade.commands import main as cli
from plantigrade.commands.parsing import SHELLS


def said(capsys) -> str:
    """Return what was printed, the frame of the parser left out."""
    out, err = capsys.readouterr()
    assert not out
    return " ".join(line.strip("│ ") for line in err.splitlines())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("fit walk.c3d --height tall", "--height: 'tall' is not a number"),
        ("fit walk.c3d --cutoff fast", "--cutoff: 'fast' is not a number"),
        ("demo --seed x", "--seed: 'x' is not a whole number"),
        ("synthesize walk --steps 2.5", "--steps: '2.5' is not a whole number"),
        ("synthesize walk --turn left", "--turn: 'left' is not a number"),
        ("synthesize walk --heights 0.1 high", "--heights: 'high' is not a number"),
        ("synthesize reach --target 1 2 x", "--target: 'x' is not a number"),
        ("synthesize reach --target 1 2", "'--target'. Expected 3 values"),
        ("fit walk.c3d --feet flat", "('rigid', 'two-segment', 'multi-segment')"),
        ("fit walk.c3d --feet None", "'None'"),
        ("fit walk.c3d --height " + "9" * 5000, "height must be 0.5–2.5 m"),
        ("demo --seed " + "9" * 5000, "is not a whole number"),
        # options of another command, or that mean nothing here
        ("fit walk.c3d --no-dynamics", "--no-dynamics"),
        ("fit walk.c3d --seed 3", "--seed"),
        ("reproduce walk.c3d --seed 3", "--seed"),
        ("fit walk.c3d --address tcp://here", "--address needs --backend ray or dask"),
        ("demo --jobs 2", "--jobs"),
        ("demo --cutoff 6", "--cutoff"),
        ("model --seed 3", "--seed"),
        ("model --overwrite", "--overwrite has no effect without --out"),
        ("view run --height 1.8", "--height"),
        ("report run --out x", "--out"),
        ("data . --jobs 2", "--jobs"),
        ("convert a.c3d b.trc --seed 1", "--seed"),
        ("experiment gait-table --seed 1", "--seed"),
        ("synthesize squat --cutoff nan --static /nope", "--cutoff"),
        ("synthesize walk --jobs 2", "--jobs"),
        ("synthesize walk --strides 3", "strides needs periodic"),
        ("synthesize walk --periodic --steps 6", "a periodic walk has no number of steps"),
        ("synthesize track --recording a.c3d --solver ipopt", "--solver"),
    ],
)
def test_a_refusal_is_a_sentence(words, sentence, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(words.split()) == 2
    text = said(capsys)
    assert sentence in text and list(tmp_path.iterdir()) == []
    for leak in ("NoneType", "class '", "no type matching", "Traceback"):
        assert leak not in text


@pytest.mark.parametrize(
    ("file", "option", "sentence"),
    [
        ("cmu_bvh/07_01.bvh", "--marker-set", "marker_set has no effect on 07_01.bvh"),
        ("cmu_asfamc/16_15.amc", "--static", "static has no effect on 16_15.amc"),
        ("c3d/HC038A11.c3d", "--skeleton", "C3D files have no option 'skeleton'"),
    ],
)
def test_options_that_mean_nothing_to_a_file(data, file, option, sentence, capsys, tmp_path):
    words = ["fit", str(data / file), option, __file__, "--quiet", "--out", str(tmp_path / "x")]
    assert cli.main(words) == 2
    assert sentence in said(capsys) and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("shell", SHELLS)
def test_there_is_a_script_for_each_shell(shell, capsys):
    assert cli.main(["--print-completion", shell]) == 0
    script = capsys.readouterr().out
    for name in cli.COMMANDS:
        assert name in script
    assert "zhakatayev2023" in script and "interior-point" in script and "--chair-height" in script
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=script, text=True, check=True)


def test_another_shell_is_refused(capsys):
    assert cli.main(["--print-completion", "tcsh"]) == 2
    assert cli.main(["--print-completion"]) == 2
    assert "there is one for bash, zsh, fish" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_what_bash_offers(tmp_path, capsys):
    """Tab after Tab in a real bash, where no NumPy can be loaded."""
    assert cli.main(["--print-completion", "bash"]) == 0
    (tmp_path / "script").write_text(capsys.readouterr().out)
    tabs = {
        "plantigrade sy": {"synthesize"},
        "plantigrade re": {"report", "reproduce", "retarget"},
        "plantigrade synthesize si": {"side-step", "sit-to-stand"},
        "plantigrade synthesize walk --sp": {"--speed"},
        "plantigrade synthesize walk --chair": set(),
        "plantigrade synthesize sit-to-stand --chair": {"--chair-height"},
        "plantigrade synthesize walk --solver i": {"interior-point", "ipopt"},
        "plantigrade fit --feet ": {"rigid", "two-segment", "multi-segment"},
        "plantigrade fit --jo": {"--jobs", "--joints"},
        "plantigrade reproduce walk.c3d --tasks sp": {"split-com"},
    }  # fmt: skip
    program = ["source ./script", "complete -p plantigrade"]
    for words in tabs:
        last = "''" if words.endswith(" ") else ""
        program += [
            f"COMP_WORDS=({words} {last}); COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))",
            'COMPREPLY=(); _tyro_plantigrade; echo "= ${COMPREPLY[*]}"',
        ]
    heavy = tmp_path / "heavy" / "numpy.py"
    heavy.parent.mkdir()
    heavy.write_text("raise SystemExit('NumPy was loaded')")
    path = os.pathsep.join((os.path.dirname(sys.executable), os.environ["PATH"]))
    done = subprocess.run(
        ["bash", "-c", "\n".join(program)], cwd=tmp_path, capture_output=True, text=True,
        env=os.environ | {"PATH": path, "PYTHONPATH": str(heavy.parent)},
    )  # fmt: skip
    first, *offered = done.stdout.splitlines()
    assert re.search(r"-o default .*plantigrade", first), "files complete where nothing else does"
    found = [set(line.removeprefix("=").split()) for line in offered]
    assert dict(zip(tabs, found, strict=True)) == tabs, done.stderr
