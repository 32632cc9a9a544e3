"""Case -> [assembly] -> AssembledModel: the objects of the core, with names for their indices."""
