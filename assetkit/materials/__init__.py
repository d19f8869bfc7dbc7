"""Materials of one object: clean render materials, surface appearance and colours, and the substance of each part."""
