"""The layer rule: a folder imports only from folders above it, never from a neighbour on its line.

The tree of every module is walked, so imports inside functions and under ``TYPE_CHECKING`` count.
"""

import ast
import importlib
from pathlib import Path

import pytest

import plantigrade

ROOT = Path(plantigrade.__file__).parent

# Each line may import from the lines above it only.
LAYERS = (
    ("printable",),
    ("errors",),
    (
        "arrays",
        "constants",
        "data_files",
        "extras",
        "interrupts",
        "lazy",
        "locks",
        "notes",
        "options",
        "side_names",
        "signatures",
        "threads",
        "toml",
    ),
    ("bounds",),
    ("spatial",),
    ("charts",),
    ("models", "motion"),
    ("contact", "skin"),
    ("io",),
    ("datasets", "record"),
    ("kinematics",),
    ("batched",),
    ("dynamics",),
    ("wbc",),
    ("ordered_tasks", "trajopt", "world"),
    ("control",),
    ("learn", "live", "robots", "vaulting"),
    ("analyze",),
    ("pages",),
    ("exchange",),
    ("workflows",),
    ("commands",),
    ("__main__",),
)
RANK = {name: rank for rank, line in enumerate(LAYERS) for name in line}

# The folders next to the package use it; only the command of that name looks for the experiments.
FOLDERS = {"benchmarks", "examples", "experiments", "tests"}
FINDER = "plantigrade.commands.experiment"

# Two engines at run time would mean two conventions everywhere: the second one checks the first, in
# the tests, and is never imported by the package.
ORACLES = {"pinocchio"}

OWN = ("__version__", "__file__")  # of the root itself
# The calls from a room to the face: `run.report()` and `run.view()` draw pages, `run.export()`
# writes files of other programs; both lie below the record.
FACE = {("plantigrade.record.run", f"plantigrade.{name}") for name in ("report", "view", "export")}

FILES = sorted(ROOT.rglob("*.py"))


def module_name(path: Path) -> str:
    """Return the dotted name of the module in ``path``."""
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(tree: ast.AST, name: str, *, is_package: bool) -> list[tuple[int, str]]:
    """Return line and dotted name of everything a module imports, wherever it stands in it."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:  # relative: level 1 is the package the module lies in
                parts = name.split(".") + ([""] if is_package else [])
                base = ".".join(filter(None, [*parts[: -node.level], base]))
            # `from plantigrade import motion` imports a folder, `from plantigrade.motion import x`
            # something of it; the longest name says which folder it is in both cases.
            found += [(node.lineno, f"{base}.{alias.name}") for alias in node.names]
        elif isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "plantigrade":
            found.append((node.lineno, f"plantigrade.{node.attr}"))
        elif (
            isinstance(node, ast.Call)
            and getattr(node.func, "attr", getattr(node.func, "id", ""))
            in ("import_module", "require", "__import__")
            and node.args
            and isinstance(node.args[0], ast.Constant)
            and isinstance(node.args[0].value, str)
        ):
            found.append((node.lineno, node.args[0].value))
    return found


def annotations(tree: ast.AST) -> set[int]:
    """Return the lines that only checkers of types read."""
    return {
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.If)
        and any(
            "TYPE_CHECKING" in (getattr(n, "id", ""), getattr(n, "attr", ""))
            for n in ast.walk(node.test)
        )
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }


def broken_rules(name: str, tree: ast.AST, *, is_package: bool) -> list[str]:
    """Return one sentence for each import of module ``name`` that the layers forbid."""
    own = name.split(".")[1] if "." in name else ""
    complaints = []
    for line, target in imports(tree, name, is_package=is_package):
        parts = target.split(".")
        if parts[0] in ORACLES:
            complaints.append(f"line {line}: {parts[0]} is for tests only")
        if parts[0] in FOLDERS and name != FINDER:
            complaints.append(f"line {line}: {parts[0]} is not installed with the package")
        if parts[0] != "plantigrade" or len(parts) < 2 or parts[1] in OWN:
            continue
        if parts[1] == own or (name, target) in FACE:
            continue
        if not own:  # the face loads what it offers when it is first used
            if line not in annotations(tree):
                complaints.append(f"line {line}: {target} is loaded with the package itself")
            continue
        if parts[1] not in RANK:
            complaints.append(f"line {line}: {target} is in no layer")
        elif RANK[parts[1]] > RANK[own]:
            complaints.append(f"line {line}: {target} lies below {own}")
        elif RANK[parts[1]] == RANK[own]:
            complaints.append(f"line {line}: {target} is a neighbour on the line of {own}")
    return complaints


@pytest.mark.parametrize("path", FILES, ids=lambda path: module_name(path))
def test_module_keeps_to_its_layer(path):
    name = module_name(path)
    own = name.split(".")[1] if "." in name else ""
    assert not own or own in RANK, f"{own} is in no layer: add it to LAYERS where it belongs"
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert not broken_rules(name, tree, is_package=path.name == "__init__.py")


def graph(trees: dict[str, ast.AST], *, loaded: bool = True) -> dict[str, set[str]]:
    """Return which modules of the package each module imports, wherever the import stands.

    With ``loaded``, what is imported for annotations alone does not count: it is never loaded.
    """
    found: dict[str, set[str]] = {}
    for name, tree in trees.items():
        is_package = any(other.startswith(f"{name}.") for other in trees)
        hidden = annotations(tree) if loaded else set()
        found[name] = set()
        for line, target in imports(tree, name, is_package=is_package):
            if line in hidden:
                continue
            while target not in trees and "." in target:
                target = target.rpartition(".")[0]
            if target in trees and target != name:
                found[name].add(target)
    return found


def cycles(edges: dict[str, set[str]]) -> list[set[str]]:
    """Return the sets of modules that import each other, directly or around (Tarjan)."""
    order, low, stack, found = {}, {}, [], []

    def visit(node: str) -> None:
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in sorted(edges[node]):
            if other not in order:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], order[other])
        if low[node] == order[node]:
            group = set()
            while node not in group:
                group.add(stack.pop())
            if len(group) > 1:
                found.append(group)

    for node in sorted(edges):
        if node not in order:
            visit(node)
    return found


def test_no_modules_import_each_other():
    """Also inside a room and for annotations; faces, which only pass names on, do not count."""
    trees = {module_name(p): ast.parse(p.read_text("utf-8")) for p in FILES}
    edges = graph(trees, loaded=False)
    faces = {name for name in trees if any(other.startswith(f"{name}.") for other in trees)}
    plain = {name: targets - faces for name, targets in edges.items() if name not in faces}
    assert cycles(plain) == []


def test_controllers_are_siblings_above_the_toolbox_of_gait():
    """A walk that stops hands over to balance; else no controller knows another one."""
    known = {
        "gait": set(),
        "balance": {"gait"},
        "replay": {"gait"},
        "pendulum": {"gait", "balance"},
    }
    edges = graph({module_name(p): ast.parse(p.read_text("utf-8")) for p in FILES})
    for room, others in known.items():
        for name in (each for each in edges if f".control.{room}" in each):
            found = {target.split(".")[2] for target in edges[name] if ".control." in target}
            assert found & {*known} <= {room, *others}, name


def test_cycles_are_found():
    sources = {
        "plantigrade.a": "def f():\n    from plantigrade.b import g",
        "plantigrade.b": "import plantigrade.c",
        "plantigrade.c": "from plantigrade.a import f",
        "plantigrade.d": "if TYPE_CHECKING:\n    from plantigrade.e import E",
        "plantigrade.e": "from plantigrade.d import D",
    }
    trees = {name: ast.parse(text) for name, text in sources.items()}
    circle = {"plantigrade.a", "plantigrade.b", "plantigrade.c"}
    annotated = {"plantigrade.d", "plantigrade.e"}
    assert cycles(graph(trees)) == [circle]
    assert cycles(graph(trees, loaded=False)) == [circle, annotated]


@pytest.mark.parametrize(
    ("name", "source", "words"),
    [
        ("plantigrade.models.human", "from plantigrade.motion import Motion", "neighbour"),
        ("plantigrade.motion.motion", "from plantigrade.models import Human", "neighbour"),
        ("plantigrade.motion.motion", "import plantigrade.io.c3d", "lies below"),
        ("plantigrade.io.c3d", "def f():\n    from plantigrade.pages import draw", "lies below"),
        ("plantigrade.world.world", "from ..ordered_tasks import solve", "neighbour"),
        ("plantigrade.world.world", "from plantigrade import control", "lies below"),
        ("plantigrade.io", "from ..commands import main", "lies below"),
        ("plantigrade.io.c3d", "import_module('plantigrade.commands.fit')", "lies below"),
        ("plantigrade.dynamics.inverse", "import pinocchio as pin", "tests only"),
        ("plantigrade.workflows.fit", "from experiments.table import Row", "not installed"),
        ("plantigrade.io.c3d", "import plantigrade.helpers", "no layer"),
        ("plantigrade", "from plantigrade.record import Run", "with the package itself"),
        ("plantigrade.io.c3d", "import plantigrade\nplantigrade.report(1)", "no layer"),
        ("plantigrade.io.c3d", "from plantigrade import fit", "no layer"),
        ("plantigrade.record.run", "import plantigrade\nplantigrade.fit(1)", "no layer"),
    ],
)
def test_the_rule_itself_catches(name, source, words):
    complaints = broken_rules(name, ast.parse(source), is_package=name.count(".") == 1)
    assert len(complaints) == 1 and words in complaints[0]


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("plantigrade.io.c3d", "from plantigrade.motion import Recording\nfrom .axes import turn"),
        ("plantigrade.commands.main", "from plantigrade import __version__"),
        ("plantigrade.models.human", "import numpy as np\nfrom plantigrade.errors import *"),
        ("plantigrade", "if TYPE_CHECKING:\n    from plantigrade.record import Run"),
        ("plantigrade.record.run", "import plantigrade\nplantigrade.report(1)"),
        ("plantigrade.commands.main", "import plantigrade\nplantigrade.__version__"),
    ],
)
def test_the_rule_itself_allows(name, source):
    assert not broken_rules(name, ast.parse(source), is_package=False)


@pytest.mark.parametrize(
    "name",
    [module_name(path) for path in FILES if "__all__" in path.read_text(encoding="utf-8")],
)
def test_every_public_name_exists(name):
    module = importlib.import_module(name)
    missing = [each for each in module.__all__ if not hasattr(module, each)]
    assert not missing
    assert len(set(module.__all__)) == len(module.__all__)
