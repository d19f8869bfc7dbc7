"""Random damage to real files of every format that Mana reads: a value or a code for each, within limits."""
