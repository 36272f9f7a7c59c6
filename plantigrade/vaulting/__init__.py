"""The vaulting model: a planar, torque-driven gymnast on the table.

After a conference report on the table contact of gymnastic vaulting [Cheng2009]_.

Names are loaded on first use, so that settings do not import NumPy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.table import Table

if TYPE_CHECKING:
    from plantigrade.vaulting.changes import sensitivity
    from plantigrade.vaulting.result import Vaulted
    from plantigrade.vaulting.search import Search, searched
    from plantigrade.vaulting.segments import Segments
    from plantigrade.vaulting.simulation import Vault

__all__ = [
    "Approach",
    "Search",
    "Segments",
    "Table",
    "Vault",
    "Vaulted",
    "searched",
    "sensitivity",
]

_HOMES = {
    "Search": "search",
    "Segments": "segments",
    "Vault": "simulation",
    "Vaulted": "result",
    "searched": "search",
    "sensitivity": "changes",
}


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
