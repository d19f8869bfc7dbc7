"""Tests of `scenec.solve`: regions, families, search and whole solves."""
