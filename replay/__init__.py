"""Replay augmentation: recorded episodes with new static context outside the proven swept volume of all that moves."""
