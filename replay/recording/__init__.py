"""Recorded episodes: `episode` is the data that every reader returns, `formats.read` the entry that reads them.

Kinematics, shapes and checks of numbers are shared by all formats.
"""
