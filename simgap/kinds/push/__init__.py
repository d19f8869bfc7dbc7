"""Planar pushes: quasi-static sliding on a limit surface against poses and forces, and direct estimates from forces."""
