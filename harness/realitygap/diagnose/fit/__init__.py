"""Fits: parameters of effects from residuals."""
