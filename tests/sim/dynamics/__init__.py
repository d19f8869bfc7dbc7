"""Tests of `sim.dynamics`."""
