"""Tests of the pictures of a gap."""
