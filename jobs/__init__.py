"""Runs work in cells (child processes with limits); result cache, folder lock, scheduling. Read `cell` first."""
