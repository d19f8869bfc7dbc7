"""Cases of a plan: joint choices of cells in which every pose is valid. Each file holds one concept or one family."""
