"""Checks of the compiler on itself: invariants between phases, and the independent judge of scenes and plans."""
