"""A page in the browser on which a contact is chosen, changed and seen; it never leaves this computer."""
