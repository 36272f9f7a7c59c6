"""A human surface over the solids of a Human: fitted to the person, moved with the bodies.

Physics sees capsules, boxes and spheres; people look at a :class:`Skin`. It is
fitted once and posed from the positions and orientations of MuJoCo's bodies::

    skin = Skin.of(human)
    vertices = skin.posed(data.xpos, data.xquat)  # (n, 3) [m], of skin.faces

A multi-segment foot also has its sixteen bones, :func:`foot_bones`.

The surface comes from assets of MakeHuman that are in the public domain; ``NOTICE.md`` beside it
tells their origin.
"""

from plantigrade.skin.foot_bones import FootBone, foot_bones
from plantigrade.skin.skin import Skin

__all__ = ["FootBone", "Skin", "foot_bones"]
