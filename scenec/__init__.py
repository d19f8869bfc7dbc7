"""Scene compiler: a semantic scene program becomes a whole, checked scene, a proof that there is none, or a limit."""
