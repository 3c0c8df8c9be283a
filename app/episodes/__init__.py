"""The episodes of the active run in the window: found, listed, shown, exported."""
