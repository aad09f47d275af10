"""One branch of an oscillator traced by compiled kernels."""
