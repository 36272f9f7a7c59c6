"""The numbers of controllers that were chosen, counted in their source."""

import ast
from collections import Counter
from pathlib import Path

import plantigrade

ROOMS = ("control", "wbc")
"""Packages whose numbers are counted."""
KINDS = ("Settings", "Gains", "Weights")
"""Ends of the names of classes of settings."""


def chosen_numbers(package: Path | None = None) -> Counter[str]:
    """Return how many numbers there are, by kind, in the packages :data:`ROOMS`.

    ``"settings"``: numbers, and tuples of numbers, that are the usual value of a setting; ``"other
    values"``: those with which a component differs from its class; ``"constants"``: numbers of a
    module, such as tolerances and resolutions. A setting whose usual value is that of another, or
    follows from it, was not chosen.

    Args:
        package: Folder of the package; the one that is imported if absent.
    """
    folder = package or Path(plantigrade.__file__).parent
    found: Counter[str] = Counter()
    for path in (file for room in ROOMS for file in sorted((folder / room).rglob("*.py"))):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found["constants"] += sum(_is_number(_value(each)) for each in tree.body)
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef) and node.name.endswith(KINDS):
                found["settings"] += sum(_is_number(_value(each)) for each in node.body)
            elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(KINDS):
                found["other values"] += sum(_is_number(own.value) for own in node.keywords)
    return found


def _value(statement: ast.stmt) -> ast.expr | None:
    """Return what a statement assigns; None where it does not."""
    return statement.value if isinstance(statement, ast.Assign | ast.AnnAssign) else None


def _is_number(node: ast.expr | None) -> bool:
    """Return whether an expression is of numbers alone; switches are none."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return _is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return _is_number(node.left) and _is_number(node.right)
    if isinstance(node, ast.Tuple):
        return bool(node.elts) and all(_is_number(each) for each in node.elts)
    if isinstance(node, ast.Call):
        return bool(node.args) and all(_is_number(each) for each in node.args)
    return False
