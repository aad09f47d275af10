"""Exciter, platform and analyzer in one launch: `ros2 launch qzs_rig rig.launch.py`."""

import os
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode

from launch import LaunchDescription

ARGUMENTS = {
    'scenario': (
        'vertical_sweep',
        'name of a scenario in the package, or path of a ROS parameter file',
    ),
    'mode': ('', 'lockstep or real_time; empty: what the scenario says'),
    'folder': ('', 'folder of the run; empty: runs/<time>_<scenario>_<id> in the current folder'),
    'namespace': ('', 'namespace of all nodes and topics'),
    'autostart': ('true', 'false leaves configure and activate to a lifecycle manager'),
    'log_level': ('info', 'debug, info, warn, error'),
}


def generate_launch_description():
    """The three nodes, loopback only unless the caller's environment says otherwise."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    environment = [
        SetEnvironmentVariable(name, value)
        for name, value in _environment().items()
        if name not in os.environ
    ]
    return LaunchDescription([*declared, *environment, OpaqueFunction(function=_nodes)])


def _nodes(context):
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    scenario = _scenario(value['scenario'])
    common = {'autostart': value['autostart'] == 'true'}
    mode = {'run.mode': value['mode']} if value['mode'] else {}
    own = {
        'analyzer': {'folder': value['folder']},
        'platform': {},
        'exciter': {'scenario': Path(scenario).stem, **mode},
    }
    nodes = {
        role: LifecycleNode(
            package='qzs_rig',
            executable=role,
            name=role,
            namespace=value['namespace'],
            parameters=[scenario, {**common, **parameters}],
            ros_arguments=['--log-level', value['log_level']],
            output='screen',
        )
        for role, parameters in own.items()
    }
    # the exciter leads: when it ends, the run is over
    over = RegisterEventHandler(
        OnProcessExit(target_action=nodes['exciter'], on_exit=[EmitEvent(event=Shutdown())])
    )
    return [*nodes.values(), over]


def _scenario(name):
    shipped = _share() / 'config' / f'{name}.yaml'
    return str(shipped) if shipped.is_file() else name


def _environment():
    profiles = str(_share() / 'config' / 'fastdds.xml')
    return {
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'FASTDDS_DEFAULT_PROFILES_FILE': profiles,
    }


def _share():
    return Path(get_package_share_directory('qzs_rig'))
