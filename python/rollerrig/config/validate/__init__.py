"""Raw tables into objects, checks across them, and mistakes as messages."""
