"""Gate rules on what is seen: meshes, normals, texture coordinates, materials, shaders, images."""
