from __future__ import annotations

import os

# before rclpy loads the middleware
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

import pytest
import rclpy  # noqa: F401  a plain import: without ROS these tests fail, they do not skip
from ros_support import ROOT, Lab

os.environ.setdefault('FASTDDS_DEFAULT_PROFILES_FILE', str(ROOT / 'config' / 'fastdds.xml'))


@pytest.fixture
def lab(tmp_path):
    with Lab(tmp_path) as lab:
        yield lab
