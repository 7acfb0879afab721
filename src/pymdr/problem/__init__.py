"""What is asked: frozen values without behaviour."""
