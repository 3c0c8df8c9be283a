"""The views of the cameras."""
