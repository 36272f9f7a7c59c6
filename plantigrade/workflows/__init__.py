"""Whole paths from files to run folders, shared by commands, experiments and users."""
