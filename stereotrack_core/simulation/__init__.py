"""People, motion and rendered stereo recordings with truth."""
