"""Whole runs through the command line on real files."""
