"""Parameters of the nodes: refused at start with a reason, guarded through the services."""

from __future__ import annotations

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from ros_support import LONG, SHORT, kept, without_ros

SERVICES = (
    ('exciter/set_parameters', SetParameters),
    ('exciter/get_parameters', GetParameters),
    ('exciter/describe_parameters', DescribeParameters),
)


def test_refused_at_start(lab):
    """One line, exit code 2; all of them at once, since a node takes half a second to start."""
    cases = {
        'excitation.amplitud.vertical:=1.0': "did you mean 'excitation.amplitude.vertical'?",
        'run.rate:=0.1': 'run.rate = 0.1 is out of range; give a float in Hz, >= 1 and <= 100000',
        'run.rate:=fast': "run.rate = 'fast' has the wrong type",
        'run.rate:=.nan': 'run.rate = nan is not finite',
        'excitation.ramp:=.inf': 'excitation.ramp = inf is not finite',
        'run.seed:=1.5': 'run.seed = 1.5 has the wrong type',
        'run.mode:=realtime': "(did you mean 'real_time'?)",
        'shaker.limits:=1': 'shaker.limits = 1 has the wrong type',
        'peers:=plattform': "peers names 'plattform'; known: platform, analyzer",
    }
    spec = {k: v for k, v in SHORT.items() if k != 'run.rate'}
    nodes = {text: lab.node('exciter', spec, ('-p', text)) for text in cases}
    for text, node in nodes.items():
        expected = 1 if text.startswith('peers') else 2
        assert node.code() == expected, (text, node.log)
        assert cases[text] in node.log
        assert 'Traceback' not in node.log


def test_integers_for_reals(lab):
    spec = SHORT | {'run.rate': 200, 'excitation.ramp': 1, 'excitation.amplitude.vertical': 1}
    nodes = lab.rig(spec)
    assert [node.code() for node in nodes] == [0, 0, 0]
    assert kept(lab.folder / 'out')[1] == without_ros(SHORT)[0]


def value_of(value):
    kind, field = {
        int: (ParameterType.PARAMETER_INTEGER, 'integer_value'),
        float: (ParameterType.PARAMETER_DOUBLE, 'double_value'),
        str: (ParameterType.PARAMETER_STRING, 'string_value'),
    }[type(value)]
    return ParameterValue(type=kind, **{field: value})


def answer(ears, name, value):
    request = SetParameters.Request(parameters=[Parameter(name=name, value=value_of(value))])
    return ears.call('exciter/set_parameters', request).results[0]


def test_set_through_the_services(lab):
    ears = lab.ears(services=SERVICES)
    idle = lab.node('exciter', SHORT, autostart=False)
    for name, value, reason in (
        ('run.rate', -1.0, 'run.rate = -1.0 is out of range'),
        ('run.rate', 'fast', 'has the wrong type'),
        ('run.rate', float('nan'), 'is not finite'),
        ('run.mode', 'realtime', "did you mean 'real_time'?"),
        ('run.raet', 500.0, 'undeclared parameter'),
    ):
        result = answer(ears, name, value)
        assert not result.successful and reason in result.reason, (name, value)
    assert answer(ears, 'run.rate', 400).successful  # an integer for a real
    request = GetParameters.Request(names=['run.rate', 'excitation.amplitude.vertical'])
    values = ears.call('exciter/get_parameters', request).values
    assert (values[0].integer_value or values[0].double_value) == 400
    assert values[1].double_value == 1.0
    request = DescribeParameters.Request(names=['run.rate'])
    descriptor = ears.call('exciter/describe_parameters', request).descriptors[0]
    assert '[Hz]' in descriptor.description
    assert descriptor.additional_constraints == '>= 1 and <= 100000'
    idle.end()


def test_fixed_while_a_run_is_on(lab):
    name = 'excitation.amplitude.vertical'
    ears = lab.ears(services=SERVICES)
    nodes = lab.rig(LONG)
    nodes[0].says('all matched')
    result = answer(ears, name, 2.0)
    assert not result.successful
    assert result.reason == f'{name} is fixed while a run is on; deactivate first'
