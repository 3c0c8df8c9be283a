"""Background work with progress and cancel; widgets are touched in the window's thread only."""
