"""The canonical robot that every engine gets, and what makes it: URDF, contact points, checks."""
