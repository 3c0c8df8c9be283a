"""Other ways from data to pose, to measure the tracker against; all else they share with it."""
