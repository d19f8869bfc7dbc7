"""Formats of recordings: one file each to read, one each to write."""
