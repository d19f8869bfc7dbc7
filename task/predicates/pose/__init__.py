"""How an object, a robot or its base stands: upright, oriented, undisturbed, home, near, balanced."""
