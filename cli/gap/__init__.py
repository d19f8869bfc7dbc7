"""`mana gap`: find, simulate and extend; chooses the engine for the sim gap."""
