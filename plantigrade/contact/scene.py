"""The scene a motion happens in as MJCF: the body, what it stands on, and what drives it."""

from plantigrade.contact.ground import Ground
from plantigrade.models import Human


def scene_xml(human: Human, ground: Ground) -> str:
    """Return the MJCF text of a person on a ground; loads and simulates in plain MuJoCo."""
    return human.xml
