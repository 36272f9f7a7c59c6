"""Planar, torque-driven model of a gymnast on the vaulting table [Cheng2009]_.

Names are loaded on first use, so that settings do not import NumPy.
"""

from typing import TYPE_CHECKING

from plantigrade.lazy import lazy
from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.table import VaultingTable

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
    "VaultingTable",
    "Vault",
    "VaultResult",
    "search_activations",
    "sensitivity",
]

__getattr__ = lazy(__name__)
