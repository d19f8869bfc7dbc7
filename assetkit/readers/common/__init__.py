"""What several readers share: file signatures, images, texture tables, corner attributes, Phong materials."""
