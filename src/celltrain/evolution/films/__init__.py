"""Thin films: the repulsion of membranes in them, and its forces."""
