"""Nanoindentation records from files of instruments."""
