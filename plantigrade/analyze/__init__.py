"""Joint angles, moments, gait measures, norms, statistics."""
