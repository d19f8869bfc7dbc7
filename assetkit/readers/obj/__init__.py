"""Reader of Wavefront OBJ and MTL files into a source model."""
