"""Tests of `render`: pictures of assets and their surfaces."""
