"""Trained policies: those of the package, by the feet of the person, and files of your own."""

from pathlib import Path
from typing import TYPE_CHECKING

from plantigrade.errors import ParameterError
from plantigrade.workflows.settings import LEARNED, POLICY, SimulateSettings

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


def policy_of(how: SimulateSettings) -> "PolicyController":
    """Return the policy that settings name.

    Raises:
        ParameterError: If they describe a person, who is that of the policy.
        FileError: If there is no such policy.
    """
    from plantigrade.learn.controller import policy_named

    known = dict(how.known)
    word = str(how.controller)
    if word == LEARNED:
        path: Path = shipped(known.pop("feet", None) or "multi-segment")
    else:
        path = Path(word)
    if known:
        raise ParameterError(
            f"a policy has its own person: leave out {', '.join(known)}, or train one for yours"
        )
    return policy_named(path)
