"""A case from its file: references resolved, values changed, everything checked."""
