"""Rebuild a recorded gait from three ordered tasks: python reproduce.py [RECORDING]."""

import subprocess
import sys
from pathlib import Path

import plantigrade as pg

recording = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/demo/textbook_walk.c3d")
if len(sys.argv) < 2 and not recording.exists():  # the demo records a textbook walk
    subprocess.run([sys.executable, "-m", "plantigrade", "demo", "--quiet"], check=True)

run = pg.reproduce(recording, tasks="paper")
recorded = run.record.references["recorded"]
for name in ("hip_flexion_r", "knee_angle_r", "ankle_angle_r"):
    ours, theirs = run.record.motion[name], recorded[name]
    print(f"{name}: {ours.max() - ours.min():.2f} rad, recorded {theirs.max() - theirs.min():.2f}")
print(f"centre of mass within {run.figures['com_error_max_mm']:.1f} mm of its path")
print("report:", run.report())
