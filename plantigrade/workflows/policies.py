"""Trained policies: those of the package, by the feet of the person, and files of your own."""

from pathlib import Path
from typing import TYPE_CHECKING

from plantigrade.errors import ParameterError
from plantigrade.workflows.simulate_settings import LEARNED, POLICY, SimulateSettings

if TYPE_CHECKING:
    from plantigrade.learn.controller import PolicyController

FOLDER = Path(__file__).resolve().parents[1] / "learn" / "policies"
"""Where the policies of the package are, one for each foot."""


def is_policy(word: str | None) -> bool:
    """Return whether a controller is a trained policy."""
    return word is not None and (word == LEARNED or word.endswith(POLICY))


def shipped(feet: str) -> Path:
    """Return the file of the policy of the package that walks on such feet.

    Raises:
        ParameterError: If there is none.
    """
    path = FOLDER / f"{feet}.npz"
    if not path.is_file():
        there = sorted(file.stem for file in FOLDER.glob("*.npz"))
        raise ParameterError(
            f"controller={LEARNED} walks on feet={' or '.join(there)}, not {feet}; train a policy "
            "of your own: plantigrade train --help"
        )
    return path


def file_of(word: str, feet: str | None = None) -> Path:
    """Return the file of a policy by its word: ``learned``, for that of the package, or itself.

    Raises:
        ParameterError: If the package has none for such feet (multi-segment if absent).
    """
    return shipped(feet or "multi-segment") if word == LEARNED else Path(word)


def policy_of(how: SimulateSettings) -> "PolicyController":
    """Return the policy that settings name.

    Raises:
        ParameterError: If they describe a person, who is that of the policy.
        FileError: If there is no such policy.
    """
    from plantigrade.learn.controller import policy_named

    known, word = dict(how.known), str(how.controller)
    path = file_of(word, known.pop("feet", None) if word == LEARNED else None)
    if known:
        raise ParameterError(
            f"a policy defines its own person: leave out {', '.join(known)}, or train one for yours"
        )
    return policy_named(path)
