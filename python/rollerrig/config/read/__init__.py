"""Where the files are, and TOML text as raw tables."""
