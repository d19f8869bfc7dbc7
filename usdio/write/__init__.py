"""Authors USD: packages (start with `package`), their meshes, materials and physics, scenes, samples, episodes."""
