"""Steady motions in the frequency domain: balanced, followed, judged, located."""
