"""Runs a fixed set of commands and compares what they write with an earlier recording, for changes that keep behaviour.

Only the command line is called, so the comparison outlives moves and renames inside the packages.
"""
