"""Other ways from measurements to a pose, to compare the tracker with."""
