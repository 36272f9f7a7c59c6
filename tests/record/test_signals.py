"""The registry of signals, and the page that prints it."""

import importlib.util
import re
from pathlib import Path

import pytest

from plantigrade.errors import ParameterError
from plantigrade.record.signals import SIGNALS, signal_of

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_page_shows_the_registry_of_today():
    spec = importlib.util.spec_from_file_location("make_signals", DOCS / "make_signals.py")
    assert spec is not None and spec.loader is not None
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    text = (DOCS / "signals.md").read_text("utf-8")
    assert text == maker.page(text), "run python docs/make_signals.py"


def test_the_example_of_the_page_runs():
    block = re.findall(r"```python\n(.*?)```", (DOCS / "signals.md").read_text("utf-8"), re.S)[0]
    exec(compile(block, "signals.md", "exec"), {})


def test_a_family_gives_way_to_its_members():
    assert signal_of("controller.com_error").unit == "m"
    assert signal_of("controller.my_error").name == "controller.*"
    assert signal_of("spline.multipliers.contact speed").name == "spline.multipliers.*"


@pytest.mark.parametrize("name", ["tasks.residuals", "user.", "mine.table", ""])
def test_an_unknown_name_is_refused(name):
    with pytest.raises(
        ParameterError, match=f"no signal is called '{name}'; .*there are .*'user.'"
    ):
        signal_of(name)


def test_the_nearest_name_comes_first():
    with pytest.raises(ParameterError, match="there are barrier.clearance,"):
        signal_of("barier.clearance")


def test_every_signal_has_a_meaning_and_a_shape():
    for signal in SIGNALS.values():
        assert signal.meaning and (signal.axes or signal.kind == "word"), signal
        assert signal.kind == "number" or not signal.unit, signal
