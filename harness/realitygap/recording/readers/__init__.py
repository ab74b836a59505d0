"""Readers: one file per kind of recording."""
