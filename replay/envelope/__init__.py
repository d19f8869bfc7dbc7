"""The swept volume of all that moves in an episode, as capsules with proven bounds; `envelope` is the entry."""
