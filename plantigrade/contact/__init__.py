"""Where a body may be touched, when, and on what."""
