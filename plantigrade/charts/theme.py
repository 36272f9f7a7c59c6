"""Colours that every picture, plot and page shares.

Left and right keep one colour each everywhere: blue for right, vermilion for left (Okabe and Ito's
palette, told apart by people with any common form of colour blindness). Plots use CSS variables
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
"""Colours for any number of things, used in this order."""

STROKE_RIGHT = f"var(--right, {RIGHT})"
STROKE_LEFT = f"var(--left, {LEFT})"
STROKE_MIDDLE = f"var(--middle, {MIDDLE})"
STROKE_REFERENCE = f"var(--recorded, {REFERENCE})"
STROKE_FORCE = "var(--force, #b07c00)"
STROKES = {"r": STROKE_RIGHT, "l": STROKE_LEFT, None: STROKE_MIDDLE, "": STROKE_MIDDLE}
"""Colours of the sides in plots."""

DOTTED = "2 3"
"""Dashes of a curve that is assumed and not measured."""

BY_SIDE = (RIGHT, LEFT, MIDDLE)
"""Of forces and places on the right, on the left, and of no known side."""
SKIN = {
    "skin": "#cc9a7b",
    "shirt": "#76839a",
    "shorts": "#262b36",
    "eye": "#ebebeb",
    "iris": "#1a1a1a",
}
"""Colours of a person with skin; sleeves and the legs of the shorts have those of the sides."""
COM = "#e0b020"
THING, PUSHED = "#b8996f", "#b0246a"
"""Of bars, boxes and packs, and of what pushes."""
BODY, LEFT_BODY, RIGHT_BODY = "#c9c3ba", "#dd9c74", "#7fa9c9"
"""Middle, left and right of a body in three dimensions: paler than lines and arrows."""
FLOOR, GRID = "#e4e8ec", "#a8b2bf"
FLOOR_DARK, GRID_DARK = "#20242b", "#525966"
