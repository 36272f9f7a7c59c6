"""How fast plantigrade is and how much memory it takes: ``python -m benchmarks``."""
