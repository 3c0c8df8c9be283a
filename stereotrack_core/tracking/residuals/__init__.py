"""What poses are measured by; a new measurement is one new file."""
