"""Whole-body control: tasks, strict hierarchies of them, forces, friction, limits."""
