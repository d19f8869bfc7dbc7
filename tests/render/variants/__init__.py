"""Tests of `render.variants`: one model under several sets of materials."""
