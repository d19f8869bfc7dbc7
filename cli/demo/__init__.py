"""`mana demo`: the main job end to end on meshes of the installed packages, and its page."""
