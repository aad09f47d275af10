"""From measured transmissibility back to the platform: parameters, intervals, advice."""
