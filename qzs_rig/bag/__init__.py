"""Bags of a run: recorder, reader, recovery and description, in the layout of rosbag2."""

from qzs_rig.bag.info import BagInfo, SampleGrid, TopicInfo, info
from qzs_rig.bag.limits import Limits
from qzs_rig.bag.reader import BagReader, TopicRows
from qzs_rig.bag.recover import RecoverReport, recover
from qzs_rig.bag.topics import Channel, TopicSpec
from qzs_rig.bag.writer import BagWriter

__all__ = [
    'BagInfo',
    'BagReader',
    'BagWriter',
    'Channel',
    'Limits',
    'RecoverReport',
    'SampleGrid',
    'TopicInfo',
    'TopicRows',
    'TopicSpec',
    'info',
    'recover',
]
