"""Programs that show how Mana is used; not part of the installed package."""
