"""What the window shows, computed from facts: the recording, the frame, the runs."""
