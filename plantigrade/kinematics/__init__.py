"""Evaluated state, inverse kinematics, fitting."""
