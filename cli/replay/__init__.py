"""`mana replay`: augment, verify, render recorded episodes and draw their envelopes."""
