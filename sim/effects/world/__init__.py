"""Effects of the surroundings: gravity, constant forces, drag."""
