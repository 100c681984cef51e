"""Messages of any type: their classes and fields, values for them, and their texts. Pure."""
