"""How surfaces look: the optical model of a material, and its section of the record."""
