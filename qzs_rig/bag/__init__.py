"""Bags of a run: recorder, reader, recovery and description, in the layout of rosbag2."""

from qzs_rig.bag.folder import Channel, TopicSpec
from qzs_rig.bag.info import BagInfo, SampleGrid, TopicInfo, info
from qzs_rig.bag.reader import BagReader, TopicRows
from qzs_rig.bag.scan import Limits
from qzs_rig.bag.writer import BagWriter, RecoverReport, recover

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
