"""A human body that moves by the laws of physics, on multi-segment feet."""

__version__ = "0.1.0"
