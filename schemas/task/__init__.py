"""Documents of tasks: the graph as it is read, what the judge knows of a scene, and its judgement of a log."""
