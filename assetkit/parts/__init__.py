"""Parts of an object: proposed, made one, labelled, put in order."""
