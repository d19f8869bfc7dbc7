"""Tests of `scenec.analyse`: the interaction graph."""
