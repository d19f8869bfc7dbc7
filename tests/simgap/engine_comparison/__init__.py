"""Tests of the comparison with the engine of the user."""
