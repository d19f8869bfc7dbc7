"""Jointed mechanisms: doors, drawers, pendulums, servos, axes."""
