"""Import of optional libraries, with an error that names the extra to install."""

import importlib
from types import ModuleType

from plantigrade.errors import MissingExtra


def require(module: str, extra: str) -> ModuleType:
    """Return the imported ``module``.

    Args:
        module: Dotted name of the module.
        extra: The extra of this package that installs it.

    Raises:
        MissingExtra: If the library is not installed; errors inside the library pass through.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module.split(".")[0]:
            raise
        raise MissingExtra(
            f"{module} is required but not installed: pip install 'plantigrade[{extra}]'"
        ) from error
