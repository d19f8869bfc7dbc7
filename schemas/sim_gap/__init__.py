"""Outputs of the sim gap as data, SI units (design: sim gap contract; extend, never rename)."""
