"""Documents of tasks: the graph as it is read, what the judge knows of a scene, and its result of a log."""
