"""`mana scene`: compile, diagnose, explain, edit and render scene programs."""
