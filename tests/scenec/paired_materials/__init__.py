"""Tests of `scenec.paired_materials`."""
