"""Tests of `sim.effects.robot`."""
