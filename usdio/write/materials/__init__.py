"""Authors the materials of a package: one file per shader that is written, listed in `outputs`."""
