"""Joint sets: the bodies of four papers as presets over one anatomy.

=======  =========  ==================================================================
preset   moving     description
         segments
=======  =========  ==================================================================
``42``   19         hierarchical gait paper: 8 per arm, 7 per leg, 6 pelvis, 3 lower
                    back, 3 neck; native foot ``two-segment``
``43``   20         spline paper: abdomen, thorax and neck of 3 each, forearms of two
                    bones; native foot ``two-segment``
``58``   25         pendulum paper, the CMU skeleton: three joints in the back, three in
                    the neck, clavicles, ankles of 3 (its 30 joints count five that do
                    not move: two hips to the pelvis, thumbs and fingers, and the root);
                    native foot ``two-segment``
``66``   21         foot paper: twelve ball joints (as three hinges each) and 12 degrees
                    of freedom in each foot; native foot ``multi-segment``
=======  =========  ==================================================================

Each preset can be combined with each foot, which adds coordinates on each side: 0 for ``rigid``, 1
for ``two-segment``, 12 for ``multi-segment``.
"""

from dataclasses import dataclass

from plantigrade.data_files import toml_tree
from plantigrade.errors import ParameterError

JOINT_SETS = ("42", "43", "58", "66")


@dataclass(frozen=True)
class MovingPart:
    """A moving part with its body and coordinates."""

    part: str  #: Name in the anatomy, without side
    body: str  #: Name of the body, without side
    coordinates: tuple[str, ...]  #: Coordinates without side, in order of rotation


def _parts(table: str) -> dict[str, tuple[MovingPart, ...]]:
    """Return the moving parts of a table, by joint set or foot."""
    return {
        name: tuple(MovingPart(part, body, tuple(names)) for part, body, names in rows)
        for name, rows in toml_tree("plantigrade.models", "joint_sets.toml")[table].items()
    }


_PRESETS, _FOOT_JOINTS = _parts("joints"), _parts("feet")

NATIVE_FEET = {**dict.fromkeys(("42", "43", "58"), "two-segment"), "66": "multi-segment"}


def moving_parts(joints: str, feet: str) -> dict[str, MovingPart]:
    """Return the moving parts of a joint set with a kind of foot, by name of the part without side.

    Args:
        joints: One of :data:`JOINT_SETS`.
        feet: One of :data:`plantigrade.models.feet.FEET`.
    """
    if joints not in _PRESETS:
        raise ParameterError(f"joints is {joints!r}; allowed are {', '.join(JOINT_SETS)}")
    if feet not in _FOOT_JOINTS:
        raise ParameterError(f"feet is {feet!r}; allowed are {', '.join(_FOOT_JOINTS)}")
    return {m.part: m for m in (*_PRESETS[joints], *_FOOT_JOINTS[feet])}
