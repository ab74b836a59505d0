"""The likelihood: how far a sample may be off without meaning anything."""
