"""Inverse dynamics and contact wrenches."""
