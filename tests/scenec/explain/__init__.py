"""Tests of `scenec.explain`: conflicts and suggested edits."""
