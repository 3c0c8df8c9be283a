"""What the images and depths themselves say about a recording's cameras, pairs and clocks."""
