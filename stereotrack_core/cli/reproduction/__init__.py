"""Making, tracking and writing what `stereotrack reproduce` shows."""
