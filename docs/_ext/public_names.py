"""Public names: listed by package, and documented on one page only, under the name one imports.

``public-names:: PACKAGE`` is a table of what a package offers. A class that two packages offer, or
that a package offers from one of its modules, is documented where it is offered first; the other
pages link there.
"""

import importlib
import importlib.util
import re
from pathlib import Path
from types import ModuleType
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.ext.autosummary import Autosummary

ROOT = "plantigrade"
MODULES = Path(__file__).parents[1] / "api" / "modules.md"
OPTIONAL = ("gymnasium", "stable_baselines3", "torch", "ray", "dask", "distributed", "pandas")
"""Libraries that the pages are built without where they are not installed."""


def packages() -> list[str]:
    """Return the package, then each of its modules that says what it offers, in page order."""
    names = re.findall(rf"^   ({ROOT}[\w.]*)$", MODULES.read_text("utf-8"), re.M)
    return [ROOT, *(n for n in names if hasattr(importlib.import_module(n), "__all__"))]


def public_names(package: str) -> list[str]:
    """Return the full names of what a package offers and no package before it."""
    elsewhere = documented_elsewhere()
    offered = importlib.import_module(package).__all__
    names = (f"{package}.{name}" for name in offered if not name.startswith("__"))
    return [n for n in names if n not in elsewhere and not isinstance(_value(n), ModuleType)]


def documented_elsewhere() -> dict[str, str]:
    """Return name on a page where it is not documented → name under which it is documented."""
    home: dict[str, str] = {}
    elsewhere: dict[str, str] = {}
    for package in packages():
        for name in importlib.import_module(package).__all__:
            here = f"{package}.{name}"
            definition = _definition(here)
            if definition is not None:
                first = home.setdefault(definition, here)
                elsewhere |= {each: first for each in (definition, here) if each != first}
    return elsewhere


def _definition(name: str) -> str | None:
    """Return where a class or a function is defined; None for anything else."""
    value = _value(name)
    module, own = getattr(value, "__module__", None), getattr(value, "__qualname__", None)
    return f"{module}.{own}" if str(module).startswith(ROOT) and own else None


def _value(name: str) -> Any:
    module, _, own = name.rpartition(".")
    return getattr(importlib.import_module(module), own)


class PublicNames(Autosummary):
    """A table of what a package offers."""

    required_arguments, has_content = 1, False

    def run(self) -> list:
        """Return the table, and below it the links of constants, which have no first sentence."""
        names = public_names(self.arguments[0])
        self.options["nosignatures"] = None
        self.content = StringList([n for n in names if _definition(n)], source="")
        made = super().run() if self.content else []
        constants = [f":py:obj:`~{name}`" for name in names if not _definition(name)]
        if constants:
            inline, messages = self.state.inline_text(
                f"Constants: {', '.join(constants)}.", self.lineno
            )
            made += [nodes.paragraph("", "", *inline), *messages]
        return made


def setup(app: Any) -> dict:
    """Add the directive, and tell the template of modules what is documented elsewhere."""

    def configure(app: Any, config: Any) -> None:
        absent = [name for name in OPTIONAL if importlib.util.find_spec(name) is None]
        config.autodoc_mock_imports = [*config.autodoc_mock_imports, *absent]
        config.autosummary_context = {"elsewhere": documented_elsewhere()}

    app.add_directive("public-names", PublicNames)
    app.connect("config-inited", configure, priority=0)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
