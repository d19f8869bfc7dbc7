"""How much of a gap is the engine's: the declared mechanism rolled out here and in the user's engine at its step."""
