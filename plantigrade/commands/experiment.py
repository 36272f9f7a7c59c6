"""Recompute a published table or figure: the command, whose experiments are part of a checkout.

The folder ``experiments`` lies next to the package and is not installed with it.
"""

import importlib
import sys
from pathlib import Path
from typing import Any

from plantigrade.errors import CheckoutNeeded

CHECKOUT = Path(__file__).resolve().parents[2]
"""The checkout that the package is run from; the folder of the libraries where it is installed."""


def find_checkout() -> Path:
    """Return the checkout that the package is run from, or else the current folder if it is one."""
    for folder in (CHECKOUT, Path.cwd()):
        if (folder / "experiments" / "command.py").is_file():
            return folder
    raise CheckoutNeeded(
        "the experiments are not installed with the package: run this command in a checkout of "
        "plantigrade's repository (or in its unpacked source distribution)"
    )


def __getattr__(name: str) -> Any:
    """Return ``Command``, the options of the experiments, from the checkout."""
    if name != "Command":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    folder = f"{find_checkout()}"
    if folder not in sys.path:
        sys.path.insert(0, folder)
    return importlib.import_module("experiments.command").Command
