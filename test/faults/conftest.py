"""Real nodes for the tests of this folder."""

from ros_support import lab  # noqa: F401  a fixture
