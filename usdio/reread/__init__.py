"""Re-reading of what Mana wrote: bodies of packages and whole scenes, for judges."""
