"""Effects at joints: friction laws, springs, backlash, stops, armature, detents, tilted axes."""
