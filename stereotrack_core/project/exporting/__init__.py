"""Export for other programs, by the command and by the window."""
