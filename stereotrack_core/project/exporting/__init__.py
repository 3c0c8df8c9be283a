"""What is written for other programs, by the command and by the window."""
