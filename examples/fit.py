"""Fit a recording and print the right knee over the gait: python fit.py [RECORDING]."""

import subprocess
import sys
from pathlib import Path

import numpy as np

import plantigrade as pg

recording = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/demo/textbook_walk.c3d")
if len(sys.argv) < 2 and not recording.exists():  # the demo records a textbook walk
    subprocess.run([sys.executable, "-m", "plantigrade", "demo", "--quiet"], check=True)

run = pg.fit(recording, feet="multi-segment")
knee = np.rad2deg(run.record.motion["knee_angle_r"])
print(f"{run.figures['marker_rms_mean_mm']:.1f} mm from the markers")
print(f"right knee {knee.min():.0f} to {knee.max():.0f} degrees")
print("report:", run.report())
