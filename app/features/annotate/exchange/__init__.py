"""Import, export, merge and agreement."""
