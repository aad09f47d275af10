"""Campaigns: one computation at many points, in chunks that survive a crash."""
