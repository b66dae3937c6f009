"""Tasks in many worlds at once."""
