"""The command line and the pytest plugin, which put the rooms together."""
