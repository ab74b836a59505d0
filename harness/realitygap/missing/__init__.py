"""The missing effort: what would have to be added to a model's joints for it to follow a recording, and its shape."""
