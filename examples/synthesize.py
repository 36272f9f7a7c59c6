"""Make a motion from a task alone and have it checked: python synthesize.py [TASK]."""

import sys

import plantigrade as pg

task = sys.argv[1] if len(sys.argv) > 1 else "squat"

run = pg.synthesize(task, height=1.65, mass=60)
verdict = pg.check(run)  # shares nothing with the optimiser
knee = run.record.torque("knee_angle_r")  # [N m]
weight = run.record.weight  # [N]
print(run.sentence)
print("verdict:", verdict.status)
print(f"knee moment up to {abs(knee).max():.0f} N m, body weight {weight:.0f} N")
print("report:", run.report())
