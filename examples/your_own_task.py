"""A task of your own: a squat with the head still, the knees bent no further than a right angle."""

from pathlib import Path

import numpy as np

import plantigrade as pg

TASK = """
[task]
name = "careful squat"
base = "squat"

[parameters]
depth = 0.2

[[term]]
type = "upright"
body = "head"
turning = 0.2

[[term]]
type = "within"
coordinate = "knee_angle_r"
high_deg = 90
"""

path = Path("careful_squat.toml")
path.write_text(TASK)
run = pg.synthesize(path)
print(run.sentence)
print(f"right knee up to {np.rad2deg(run.record.motion['knee_angle_r'].max()):.0f} degrees")
print("report:", run.report())
