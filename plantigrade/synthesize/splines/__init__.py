"""Trigonometric and polynomial splines behind one interface."""
