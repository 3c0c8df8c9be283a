"""The pretrained pose detector: what it is, and installing it."""
