"""Scene problems and packages for tests of the scene compiler."""
