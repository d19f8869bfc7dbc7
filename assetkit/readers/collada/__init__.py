"""Reader of COLLADA (.dae) files: XML, scene graph, geometry and materials into a source model."""
