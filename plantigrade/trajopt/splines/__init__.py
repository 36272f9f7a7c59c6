"""Trigonometric and polynomial splines with one interface."""
