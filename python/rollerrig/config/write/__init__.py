"""Objects as TOML text; the reference of all keys."""
