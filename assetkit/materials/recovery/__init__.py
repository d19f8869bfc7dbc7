"""Plausible materials for surfaces whose appearance is missing or degraded. Start with `recover`."""
