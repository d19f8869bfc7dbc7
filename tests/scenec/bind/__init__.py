"""Tests of `scenec.bind`: assets, components and variants bound to geometry."""
