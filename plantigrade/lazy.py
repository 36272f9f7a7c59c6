"""Names of a package that are loaded when they are first used.

They are listed once, as the imports under ``if TYPE_CHECKING:`` at the top of the package, where
checkers of types find them too.
"""

import ast
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any


def lazy(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package that imports a name when it is first used."""

    def load(name: str) -> Any:
        home = None if name.startswith("__") else homes(package).get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(home), name)

    return load


@cache
def homes(package: str) -> Mapping[str, str]:
    """Return the module of each name that a package imports for checkers of types alone."""
    loader: Any = getattr(find_spec(package), "loader", None)
    tree = ast.parse(loader.get_source(package) or "")
    blocks = (each for each in tree.body if isinstance(each, ast.If))
    return {
        alias.name: node.module
        for block in blocks
        if isinstance(block.test, ast.Name) and block.test.id == "TYPE_CHECKING"
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }
