"""Tests of the sim gap's report."""
