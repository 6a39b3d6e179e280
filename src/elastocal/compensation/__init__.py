"""From a model to joint values that put the loaded tool where it should be."""
