"""Exciter, platform and analyzer in one launch: `ros2 launch qzs_rig rig.launch.py`."""

import os
from pathlib import Path

from launch.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    Shutdown,
)
from launch.event_handlers import OnProcessExit
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode

from launch import LaunchDescription
from qzs_rig import loopback, scenario

ARGUMENTS = {
    'scenario': (
        'vertical_sweep',
        'name of a scenario in the package, or path of a ROS parameter file',
    ),
    'mode': ('', 'lockstep or real_time; empty: what the scenario says'),
    'folder': ('', 'folder of the run; empty: runs/<time>_<scenario>_<id> in the current folder'),
    'namespace': ('', 'namespace of all nodes and topics'),
    'autostart': ('true', 'false leaves configure and activate to a lifecycle manager'),
    'exit_when_done': ('true', 'false keeps the nodes for further runs'),
    'log_level': ('info', 'of all nodes'),
}
CHOICES = {
    'mode': ('', 'lockstep', 'real_time'),
    'autostart': ('true', 'false'),
    'exit_when_done': ('true', 'false'),
    'log_level': ('debug', 'info', 'warn', 'error'),
}


def generate_launch_description():
    """The three nodes, on this machine only unless the caller's environment says otherwise."""
    declared = [
        DeclareLaunchArgument(
            name, default_value=default, description=text, choices=CHOICES.get(name)
        )
        for name, (default, text) in ARGUMENTS.items()
    ]
    alone = SetEnvironmentVariable(loopback.RANGE, os.environ.get(loopback.RANGE, 'LOCALHOST'))
    return LaunchDescription([*declared, alone, OpaqueFunction(function=_nodes)])


def _nodes(context):
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    file = str(scenario.find(value['scenario']))  # refuses what is not there, and lists what is
    common = {name: value[name] == 'true' for name in ('autostart', 'exit_when_done')}
    mode = {'run.mode': value['mode']} if value['mode'] else {}
    own = {
        'analyzer': {'folder': value['folder']},
        'platform': {},
        'exciter': {'scenario': Path(file).stem, **mode},
    }
    nodes = {
        role: LifecycleNode(
            package='qzs_rig',
            executable=role,
            name=role,
            namespace=value['namespace'],
            parameters=[file, {**common, **parameters}],
            ros_arguments=['--log-level', value['log_level']],
            output='screen',
        )
        for role, parameters in own.items()
    }
    over = RegisterEventHandler(OnProcessExit(on_exit=_exited))
    return [*nodes.values(), over]


def _exited(event, context):
    """The exciter leads: when it ends, the run is over. Nobody waits for a node that failed."""
    if context.is_shutdown:
        return None
    name = event.process_name.rsplit('-', 1)[0]
    if event.returncode:
        # an exception is launch's only way to a non-zero exit code
        raise RuntimeError(f'{name} ended with exit code {event.returncode}')
    return Shutdown(reason='the run is over') if name == 'exciter' else None
