"""The banded interior point, and IPOPT as reference."""
