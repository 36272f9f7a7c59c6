"""Plots, report.html, viewer.html and the live viewer."""
