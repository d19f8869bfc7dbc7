"""Checks of a recording, one concern per file, each `(setting, trials) -> (trials, findings)`."""
