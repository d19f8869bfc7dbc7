"""Triangle meshes as arrays: topology, edges, components, welding, editing, decimation, distances, rays, sections."""
