"""How each kind of input is read under damage: `by_format.READERS` maps a format to a function of folder and file."""
