"""Pure arrays: poses, topology, repair, inertia, fits, hulls, distances. No files, no simulator."""
