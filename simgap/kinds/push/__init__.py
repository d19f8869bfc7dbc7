"""Planar pushes: quasi-static sliding on a limit surface against poses and forces, and what forces say directly."""
