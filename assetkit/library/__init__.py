"""A folder of released packages: catalogue, search, review, validation and previews."""
