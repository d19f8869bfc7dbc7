"""Gate rules on visible surfaces: meshes, normals, texture coordinates, materials, shaders, images."""
