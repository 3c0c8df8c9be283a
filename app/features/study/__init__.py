"""Studies: recordings, settings and seeds, tracked and evaluated together."""
