"""The joint law and the ground law outside an engine, for engines that lack part of them."""
