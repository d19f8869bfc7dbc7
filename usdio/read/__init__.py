"""Reading of foreign USD: meshes, materials, physics, instances, packages, guarded against hostile layers."""
