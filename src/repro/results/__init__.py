"""Stored runs gathered into tables of a fixed schema, and selections from them."""
