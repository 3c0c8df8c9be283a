"""One file for each foreign format: read and write."""
