"""ROS parameters from the one declaration: same names, bounds, units and texts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec, unknown_parameter

NODE_PARAMETERS = (
    Parameter('autostart', bool, True, '', 'configure and activate without being told'),
    Parameter('exit_when_done', bool, True, '', 'end the process after a run'),
)
"""Parameters of every node that are no part of the scenario."""

_OF_ROS = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


def declare(node: Node, sections: tuple[str, ...], own: Iterable[Parameter]) -> RunSpec:
    """Declare `sections` of the scenario and `own` parameters on `node`; returns their values.

    The node must have been built with automatically_declare_parameters_from_overrides. Values of
    other sections are accepted, since one file serves all nodes; unknown names raise InputError.
    """
    table = (*scenario.PARAMETERS, *NODE_PARAMETERS, *own)
    given = {}
    for name, override in node.get_parameters_by_prefix('').items():
        if not name.startswith(_OF_ROS):
            given[name] = override.value
            node.undeclare_parameter(name)
    known_elsewhere = {'scenario', 'run_id', 'folder', 'peers', 'bag', 'topics', 'pace', 'rate'}
    unknown = [n for n in given if n not in {p.name for p in table} | known_elsewhere]
    if unknown:
        raise InputError(unknown_parameter(unknown[0], [p.name for p in table]))
    mine = [p for p in table if p.section in sections or p in (*NODE_PARAMETERS, *own)]
    names = {p.name for p in table}
    # other sections count too: the exciter weighs the payload against the shaker's force
    spec = RunSpec.of(table, {name: value for name, value in given.items() if name in names})
    for parameter in mine:
        node.declare_parameter(parameter.name, spec.get(parameter.name), _descriptor(parameter))
    return spec


def guard(node: Node, spec: RunSpec, busy: Callable[[], bool]) -> None:
    """Check every later `ros2 param set` against the declaration; refuse it while `busy()`."""
    table = {parameter.name: parameter for parameter in spec.declared}

    def check(parameters: list[RosParameter[Any]]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name not in table:
                continue
            if busy():
                return SetParametersResult(
                    successful=False,
                    reason=f'{parameter.name} is fixed while a run is on; deactivate first',
                )
            try:
                table[parameter.name].convert(parameter.value)
            except InputError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(check)


def current(node: Node, spec: RunSpec) -> RunSpec:
    """`spec` with what was changed on the node since, `ros2 param set` included."""
    changed = {}
    for parameter in spec.declared:
        if not node.has_parameter(parameter.name):
            continue
        value = node.get_parameter(parameter.name).value
        if value is not None and value != spec.get(parameter.name):
            changed[parameter.name] = value
    return spec.override(changed)


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    unit = f' [{parameter.unit}]' if parameter.unit else ''
    return ParameterDescriptor(
        description=f'{parameter.text}{unit}',
        additional_constraints=parameter.range_text,
        # so that integers pass for reals and optional parameters may stay unset
        dynamic_typing=True,
    )
