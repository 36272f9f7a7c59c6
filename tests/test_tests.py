"""The tests themselves: they import public names, and no result depends on a clock."""

import ast
import importlib
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
# The browser is another program: it is asked a number of times, with a pause between. The command
# that damages files runs for a given time, and ends hanging processes.
CLOCKED = {TESTS / "browser.py", *(TESTS / "nasty").glob("*.py")}
FILES = [path for path in sorted(TESTS.rglob("*.py")) if path not in CLOCKED]
ROOTS = {"plantigrade", "experiments"}
CLOCKS = {"sleep", "time", "perf_counter", "monotonic", "timeout"}


def taken(tree: ast.AST) -> list[tuple[int, str, str]]:
    """Return line, module and name of all imports from the package."""
    return [
        (node.lineno, node.module, alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in ROOTS
        for alias in node.names
    ]


def nearer(module: str, name: str) -> str | None:
    """Return the package between a room and its module that exports the same object."""
    thing = getattr(importlib.import_module(module), name, None)
    parts = module.split(".")
    for k in range(2, len(parts)):
        package = importlib.import_module(".".join(parts[:k]))
        if name in getattr(package, "__all__", ()) and getattr(package, name) is thing:
            return package.__name__
    return None


def faults(source: str) -> list[str]:
    """Return the faults of a test file."""
    tree, found = ast.parse(source), []
    for line, module, name in taken(tree):
        words = [*module.split("."), name]
        if any(w.startswith("_") and not w.startswith("__") for w in words):
            found.append(f"line {line}: {module}.{name} is private")
        elif home := nearer(module, name):
            found.append(f"line {line}: take {name} from {home}, which offers it")
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.value.id == "time" and node.attr in CLOCKS:
                found.append(f"line {node.lineno}: time.{node.attr}")
        if isinstance(node, ast.keyword) and node.arg == "timeout":
            found.append(f"line {node.value.lineno}: timeout=")
    return found


def test_what_is_offered_is_taken_and_no_clock_is_read():
    found = {str(path.relative_to(TESTS)): faults(path.read_text("utf-8")) for path in FILES}
    assert {name: said for name, said in found.items() if said} == {}


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("from plantigrade.models.feet import _RADIUS", "_RADIUS is private"),
        (
            "def f():\n    from plantigrade.motion.recording import Markers",
            "from plantigrade.motion",
        ),
        ("import time\ntime.sleep(1)", "time.sleep"),
        ("import time\nassert time.perf_counter() < 20", "time.perf_counter"),
        ("process.wait(timeout=20)", "timeout="),
    ],
)
def test_faults_are_found(source, words):
    (fault,) = faults(source)
    assert words in fault


def test_what_is_right_is_left_alone():
    assert faults("import time\ntime.process_time()") == []
