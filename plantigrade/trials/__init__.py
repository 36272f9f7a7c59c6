"""Trials of walkers: walks that are pushed, tours of waypoints, and their outcomes."""
