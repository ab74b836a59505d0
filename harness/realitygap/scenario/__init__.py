"""The scenario: what happens, as people write it down."""
