"""The first pose, and a pose after a loss: whoever is in a cloud is found without help."""
