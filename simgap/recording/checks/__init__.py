"""What can be wrong with a recording: one concern per file, each `(setting, trials) -> (trials, findings)`."""
