"""Materials for tests: drawn at random, and read from MaterialX networks."""
