"""A human body that moves by the laws of physics, on feet that are feet."""

__version__ = "0.1.0"
