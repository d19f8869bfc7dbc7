"""Tests of `sim.effects.joint`."""
