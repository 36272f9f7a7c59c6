"""Conditions and costs of a task."""
