"""A platform proposed for a payload, an onset, a stroke and a level; any platform checked."""
