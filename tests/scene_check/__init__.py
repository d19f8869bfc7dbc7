"""Tests of `scene_check`."""
