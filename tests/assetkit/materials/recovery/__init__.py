"""Tests of `assetkit.materials.recovery`: what is degraded, what is filled in, and what never changes."""
