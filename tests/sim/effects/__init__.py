"""Tests of `sim.effects`."""
