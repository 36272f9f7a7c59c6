"""Planar, torque-driven model of a gymnast on the vaulting table [Cheng2009]_.

Names are loaded on first use, so that settings do not import NumPy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.table import Table

if TYPE_CHECKING:
    from plantigrade.vaulting.approach_sensitivity import sensitivity
    from plantigrade.vaulting.hand_contact import Vault
    from plantigrade.vaulting.search import Search, search_activations
    from plantigrade.vaulting.segments import Segments
    from plantigrade.vaulting.vault_result import VaultResult

__all__ = [
    "Approach",
    "Search",
    "Segments",
    "Table",
    "Vault",
    "VaultResult",
    "search_activations",
    "sensitivity",
]

_HOMES = {
    "Search": "search",
    "Segments": "segments",
    "Vault": "hand_contact",
    "VaultResult": "vault_result",
    "search_activations": "search",
    "sensitivity": "approach_sensitivity",
}


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
