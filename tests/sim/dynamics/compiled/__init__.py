"""Tests of compiled roll-outs."""
