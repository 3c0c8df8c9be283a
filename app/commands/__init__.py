"""What each command is called, does, and why it cannot be done now; one file per menu."""
