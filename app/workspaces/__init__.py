"""Named dock layouts that a person can change and reset."""
