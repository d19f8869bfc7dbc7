"""States and motion of joints: at a position, turned by so many turns, pressed so many times."""
