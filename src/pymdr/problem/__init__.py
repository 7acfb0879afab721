"""Problem values: frozen, without behaviour."""
