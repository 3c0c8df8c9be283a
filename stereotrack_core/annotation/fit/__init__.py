"""The articulated body fitted to clicked landmarks, by the tracker's own filter."""
