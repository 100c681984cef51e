"""Keys, the palette, and a user's own keymap."""
