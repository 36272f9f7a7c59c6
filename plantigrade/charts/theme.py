"""Colours shared by all pictures, plots and pages.

Left and right keep one colour each everywhere: blue for right, vermilion for left (Okabe and Ito's
palette, distinguishable with any common form of colour blindness). Plots use CSS variables
with these as fallbacks, so a drawing follows the light or dark colours of its page and also stands
alone.
"""

RIGHT = "#0072b2"
LEFT = "#d55e00"
MIDDLE = "#6b7280"
RECORDED = "#009e73"
FITTED = "#cc79a7"
REFERENCE = "#7e57c2"
FORCE = "#e0a100"
SIDE_COLOURS = {"r": RIGHT, "l": LEFT}
PALETTE = (MIDDLE, RECORDED, RIGHT, FORCE, FITTED, LEFT, "#56b4e9", REFERENCE)
"""Colours of categories, in this order."""

STROKE_RIGHT = f"var(--right, {RIGHT})"
STROKE_LEFT = f"var(--left, {LEFT})"
STROKE_MIDDLE = f"var(--middle, {MIDDLE})"
STROKE_REFERENCE = f"var(--recorded, {REFERENCE})"
STROKE_FORCE = "var(--force, #b07c00)"
STROKES = {"r": STROKE_RIGHT, "l": STROKE_LEFT, None: STROKE_MIDDLE, "": STROKE_MIDDLE}
"""Colours of the sides in plots."""

DOTTED = "2 3"  # Dash pattern of curves that are assumed, not measured

BY_SIDE = (RIGHT, LEFT, MIDDLE)
"""Colours of forces and contact points on the right, on the left, and of unknown side."""
SKIN = {
    "skin": "#cc9a7b",
    "shirt": "#76839a",
    "shorts": "#262b36",
    "sleeve_r": "#1e76ac",
    "sleeve_l": "#bd6727",
    "shorts_r": "#175377",
    "shorts_l": "#7d4a23",
    "eye": "#ebebeb",
    "iris": "#1a1a1a",
}
"""Colours of a person with skin; sleeves and the legs of the shorts have those of the sides."""
BONE = "#ece3cc"
"""Colour of the bones of a foot."""
COM = "#e0b020"
SCENE_OBJECT, PUSHED = "#b8996f", "#b0246a"
"""Colours of scene objects (bars, boxes, packs) and of perturbations."""
BODY, LEFT_BODY, RIGHT_BODY = "#c9c3ba", "#dd9c74", "#7fa9c9"
"""Colours of the body in three dimensions (middle, left, right), paler than lines and arrows."""
FLOOR, GRID = "#e4e8ec", "#a8b2bf"
FLOOR_DARK, GRID_DARK = "#20242b", "#525966"
