"""Fixtures shared by the tests of the vault; equations and machine code are made once."""

import numpy as np
import pytest

from plantigrade.models import Human
from plantigrade.vaulting import Approach, Segments, Vault, VaultingTable

# Activations: shoulders and elbows extend, hips yield at first and extend late.
NODES = np.array([[0.8, 0.9, -0.5, 0.1, 0.1]] * 3 + [[0.3, 0.6, 0.2, 0.0, 0.0]] * 3)


@pytest.fixture(scope="session")
def segments() -> Segments:
    return Segments(Human.create(1.66, 63.0, "male", "42", "rigid"))


@pytest.fixture(scope="session")
def vault(segments) -> Vault:
    return Vault(segments, VaultingTable(), Approach())


@pytest.fixture(scope="session")
def nodes() -> np.ndarray:
    return NODES
