"""Trained policies: those of the package, by the feet of the person, and files of your own."""

from pathlib import Path

from plantigrade.errors import ParameterError
from plantigrade.options import LEARNED

FOLDER = Path(__file__).resolve().parent / "policies"
"""Where the policies of the package are, one for each foot."""


def shipped(feet: str) -> Path:
    """Return the file of the policy of the package that walks on such feet."""
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
