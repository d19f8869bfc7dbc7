"""Tests of `replay.views.visible_area`."""
