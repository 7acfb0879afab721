"""Figures, texts and files: they take labelled data and callables, never a result."""
