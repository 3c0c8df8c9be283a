"""A recording made of videos or images: what was found, what is chosen, where it goes."""
