"""Writes ``plantigrade/__init__.pyi``: ``python -m tests.stub``.

Checkers of types and editors do not run the package: they read there what ``inspect.signature``
says of its public functions.
"""

import ast
import builtins
import inspect
import subprocess
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

import plantigrade as pg

PLACE = Path(pg.__file__).with_suffix(".pyi")
HEAD = '"""Made from the signatures of the public functions: python -m tests.stub."""\n\n'


def stub() -> str:
    """Return the text of the stub."""
    imports, functions = set(), []
    for name in sorted(set(pg.__all__) - {"__version__"}):
        thing = getattr(pg, name)
        if inspect.isfunction(thing) and hasattr(thing, "__signature__"):
            functions.append(_function(thing, imports))
        else:
            imports.add(f"from {thing.__module__} import {name}")
    names = ",".join(map(repr, pg.__all__))
    text = "\n".join([HEAD, *sorted(imports), "__version__: str", f"__all__ = [{names}]"])
    text += "\n\n" + "\n\n".join(functions)
    for command in (["check", "--select", "I", "--fix", "-q"], ["format", "-q"]):
        done = subprocess.run(
            ["ruff", *command, "--stdin-filename", str(PLACE), "-"],
            input=text, capture_output=True, text=True, check=True,
        )  # fmt: skip
        text = done.stdout
    return text


def _function(function: Any, imports: set[str]) -> str:
    """Return the stub of a function; add the imports that it needs."""
    module = inspect.getmodule(function)
    tree = ast.parse(inspect.getsource(function)).body[0]
    written = {a.arg: a.annotation for a in (*tree.args.args, *tree.args.kwonlyargs)}
    homes = {
        alias.name: node.module
        for node in ast.walk(ast.parse(inspect.getsource(module)))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }

    def as_written(annotation: ast.expr) -> str:
        for node in ast.walk(annotation):
            known = isinstance(node, ast.Name) and (
                hasattr(builtins, node.id) or node.id in pg.__all__
            )
            if isinstance(node, ast.Name) and not known:
                imports.add(f"from {homes.get(node.id, module.__name__)} import {node.id}")
        return ast.unparse(annotation)

    shown = []
    for each in inspect.signature(function).parameters.values():
        kind = written.get(each.name)
        kind = _kind(each.annotation, imports) if kind is None else as_written(kind)
        if each.kind is each.KEYWORD_ONLY and "*" not in shown:
            shown.append("*")
        default = "" if each.default is each.empty else f" = {each.default!r}"
        shown.append(f"{each.name}: {kind}{default}")
    returned = as_written(tree.returns)
    return f"def {function.__name__}({', '.join(shown)}) -> {returned}: ..."


def _kind(hint: Any, imports: set[str]) -> str:
    """Return a type as source; add the imports that it needs."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hint is NoneType or hint is None:
        return "None"
    if origin in (Union, UnionType):
        return " | ".join(_kind(each, imports) for each in arguments)
    if origin is Literal:
        imports.add("from typing import Literal")
        return f"Literal[{', '.join(map(repr, arguments))}]"
    if isinstance(hint, list):
        return f"[{', '.join(_kind(each, imports) for each in hint)}]"
    base = origin or hint
    if base.__module__ != "builtins":
        module = "pathlib" if base is Path else base.__module__
        imports.add(f"from {module} import {base.__name__}")
    inner = ", ".join(_kind(each, imports) for each in arguments)
    return f"{base.__name__}[{inner}]" if inner else base.__name__


if __name__ == "__main__":
    PLACE.write_text(stub(), "utf-8")
    print(PLACE)
