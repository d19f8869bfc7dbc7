"""One folder per kind of measurement: how its model is built, rolled out, read directly and searched."""
