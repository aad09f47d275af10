"""Puts this folder on the path, so that tests in all folders share `ros_support`."""

import os

from hypothesis import settings

# the same examples in every CI run: a new counterexample is for somebody who can look at it
settings.register_profile('ci', derandomize=True)
if os.environ.get('CI'):
    settings.load_profile('ci')
