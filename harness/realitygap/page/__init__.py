"""What every page shares: the shell, the style and how numbers are written."""
