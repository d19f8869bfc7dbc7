"""Checks of the compiler on itself: invariants between phases, and the input of the independent judge."""
