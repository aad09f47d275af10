"""Runs in time, many side by side, seen once a period."""
