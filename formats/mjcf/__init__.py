"""MuJoCo MJCF models: `read` and `write`; `includes`, `defaults` and `orientations` are the parts of the language."""
