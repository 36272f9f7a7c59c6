"""Import of optional libraries, with an error that names the extra to install."""

import importlib
from types import ModuleType

from plantigrade.errors import MissingExtra

RELEASED = False
"""Whether there is a release on the package index. Messages name the install command accordingly,
and a test holds README and documentation to it."""


def install_command(extra: str = "") -> str:
    """Return the command that installs the package, with an extra.

    Example:
        >>> install_command("tables").endswith("[tables]'")
        True
    """
    name = "plantigrade" if RELEASED else "."
    return f"pip install '{name}[{extra}]'" if extra else f"pip install {name}"


def require(module: str, extra: str) -> ModuleType:
    """Return the imported ``module``."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module.split(".")[0]:
            raise
        where = "" if RELEASED else " in the checkout of plantigrade"
        raise MissingExtra(
            f"{module} is required but not installed: {install_command(extra)}{where}"
        ) from error
