"""Tests of `scenec.source.paired_materials`."""
