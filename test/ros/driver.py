"""A driver of two Imus that knows nothing of the rig: plain rclpy, its own clock, rate and axes.

The base moves with a sine of fixed frequency; the top answers with the magnitude and phase given on
the command line: FREQUENCY MAGNITUDE PHASE_DEG SECONDS. Ends, in order, with SIGTERM.
"""

import math
import random
import signal
import sys
import time

import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Imu

RATE = 417.0
G = 9.80665


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('two_imus')
    try:
        drive(node, *map(float, sys.argv[1:5]))
        while True:
            signal.pause()
    finally:
        # what is killed leaves its shared memory to those that come after
        node.destroy_node()
        rclpy.shutdown()


def drive(node, hertz, magnitude, phase, seconds):
    base = node.create_publisher(Imu, '/left/imu', qos_profile_sensor_data)
    top = node.create_publisher(Imu, '/right/data', qos_profile_sensor_data)
    while not (base.get_subscription_count() and top.get_subscription_count()):
        time.sleep(0.01)
    dice = random.Random(3)
    began = time.monotonic()
    for k in range(int(seconds * RATE)):
        time.sleep(max(0.0, began + k / RATE - time.monotonic()))
        for publisher, frame, gain, turn, late in (
            (base, 'left_link', 1.0, 0.0, 0.0),
            (top, 'right_link', magnitude, math.radians(phase), 0.4 / RATE),
        ):
            # both sensors sample at their own times and say so, up to a few 10 us
            t = k / RATE + late
            a = 2.0 * gain * math.sin(2 * math.pi * hertz * t + turn)
            stamp = 1_000_000_000 + round((5.0 + t + dice.gauss(0.0, 2e-5)) * 1e9)
            message = Imu()
            message.header.frame_id = frame
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
            if publisher is base:  # x is down, in units of g
                message.linear_acceleration.x = -(a + G) / G
            else:  # y is up
                message.linear_acceleration.y = a + G
            message.orientation_covariance[0] = -1.0
            publisher.publish(message)


main()
