"""Writing of USD: packages, meshes, materials, physics, scenes, samples, episodes."""
