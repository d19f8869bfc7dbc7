"""Tests of `sim.effects.sensor`."""
