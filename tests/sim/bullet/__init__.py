"""Tests of `sim.bullet.simulator`."""
