"""What a diagnosis leaves: the file, the mended model and the page."""
