"""What only developers run: accuracy, speed, references fitted to clicks, the thesis's tables."""
