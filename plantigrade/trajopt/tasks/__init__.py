"""Tasks by name and from files."""
