"""The dressed skin of a person as glTF surfaces, one per material."""

import numpy as np

from plantigrade.charts import theme
from plantigrade.exchange.gltf import Surface, normals_of
from plantigrade.pages.shapes import rgb
from plantigrade.skin import Skin
from plantigrade.skin.dressed import dressed_mesh
from plantigrade.skin.surface import weights_in_255ths

COLOURS = {
    "skin": rgb(theme.SKIN["skin"]),
    "shirt": rgb(theme.SKIN["shirt"]),
    "sleeve_r": rgb(theme.RIGHT_BODY),
    "sleeve_l": rgb(theme.LEFT_BODY),
    "shorts_r": tuple(0.6 * part for part in rgb(theme.RIGHT_BODY)),
    "shorts_l": tuple(0.6 * part for part in rgb(theme.LEFT_BODY)),
    "eye": rgb(theme.SKIN["eye"]),
    "iris": rgb(theme.SKIN["iris"]),
}
"""Material → its colour, sRGB: left and right differ as in the viewer."""


def dressed_surfaces(skin: Skin) -> dict[str, Surface]:
    """Return the surfaces of a skin in its resting pose, by material of :data:`COLOURS`.

    The bones are those of the skin, by index.
    """
    mesh = dressed_mesh(skin)
    normals = normals_of(mesh.vertices, mesh.faces)
    bones, weights = weights_in_255ths(mesh.bones, mesh.weights)
    found = {}
    for material in COLOURS:
        faces = mesh.faces[mesh.materials == material]
        if not len(faces):
            continue
        used, corners = np.unique(faces, return_inverse=True)
        parts = (mesh.vertices[used], normals[used], corners.reshape(-1, 3))
        found[material] = Surface(*parts, bones[used], weights[used])
    return found
