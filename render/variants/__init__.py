"""Small pictures of one model under several sets of materials, and which of its surfaces is seen at each pixel."""
