"""Plans and draws for tests of the sampler."""
