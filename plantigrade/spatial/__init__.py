"""Rotations, frames and engine conventions."""
