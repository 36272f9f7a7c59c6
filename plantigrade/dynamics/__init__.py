"""Inverse dynamics, ground reactions and symbolic equations of motion."""
