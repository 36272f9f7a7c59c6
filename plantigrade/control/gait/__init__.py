"""The toolbox of every walker: gait reference, phase and contacts, swing foot, steps, tasks.

Balance, replay and the pendulum walk stand above it; it knows none of them.
"""
