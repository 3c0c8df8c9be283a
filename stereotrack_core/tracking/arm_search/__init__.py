"""Search for the arms: many proposals for both, scored jointly by what they explain."""
