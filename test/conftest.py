"""Puts this folder on the path, so that tests in all folders share `ros_support`."""
