"""rollerrig: a roller rig for railway bogies, in software."""
