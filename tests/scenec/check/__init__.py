"""Tests of `scenec.check`: invariants between the phases."""
