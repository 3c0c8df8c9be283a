"""Named arrangements of panels that a person can change and reset."""
