"""Taking pairs away from the built-in contact, and connecting force ports."""
