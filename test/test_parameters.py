"""Parameters: one declaration, refusals that show the way out, round trips."""

from __future__ import annotations

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec, parse_assignment, read_yaml

NAMES = [parameter.name for parameter in scenario.parameters()]
every_parameter = pytest.mark.parametrize('parameter', scenario.parameters(), ids=NAMES)
RATE = Parameter('run.rate', float, 500.0, 'Hz', 'samples a second', 1.0, 1e5)
BITS = Parameter('sensor.bits', int, 16, '', 'resolution', 4, 32)
DEPTH = Parameter('run.depth', float, None, 'm', 'depth', 0.0, above=True)
KIND = Parameter('run.kind', str, 'sine', '', 'kind', choices=('sine', 'sweep'))
FLAG = Parameter('run.flag', bool, True, '', 'flag')
TITLE = Parameter('run.title', str, '', '', 'title')

DIMENSIONLESS = {
    *('platform.A', 'platform.k3_hat', 'platform.L1_hat', 'platform.L0_hat', 'platform.zeta'),
    *('analyzer.periods', 'analyzer.hop_periods', 'analyzer.residual_max'),
    *('analyzer.settle_tolerance', 'analyzer.settle_periods', 'analyzer.plateau_tolerance'),
}


# --- the declaration ---


@every_parameter
def test_a_parameter_says_what_it_is_and_in_which_unit(parameter):
    assert parameter.text
    assert parameter.section in {
        *('run', 'excitation', 'shaker', 'platform', 'sensor', 'analyzer'),
    }
    # counts and choices have no unit; a real number has one or is a ratio
    if parameter.kind is float:
        assert bool(parameter.unit) != (parameter.name in DIMENSIONLESS)


@every_parameter
def test_a_default_is_allowed(parameter):
    if parameter.default is not None:
        converted = parameter.convert(parameter.default)
        assert converted == parameter.default
        assert type(converted) is parameter.kind


@every_parameter
def test_a_synonym_is_declared(parameter):
    assert set(parameter.replaces) <= set(NAMES)


def test_names_are_unique_and_none_is_a_branch_of_another():
    assert len(set(NAMES)) == len(NAMES)
    branches = {name[:k] for name in NAMES for k, sign in enumerate(name) if sign == '.'}
    assert not branches & set(NAMES)


@pytest.mark.parametrize(
    ('parameter', 'words'),
    [
        (RATE, '>= 1 and <= 100000'),
        (DEPTH, '> 0'),
        (KIND, 'one of sine, sweep'),
        (TITLE, 'any str'),
        (FLAG, 'any bool'),
    ],
)
def test_the_range_in_words(parameter, words):
    assert parameter.range_text == words


# --- values ---


@pytest.mark.parametrize(
    ('parameter', 'value', 'converted'),
    [
        (RATE, 200, 200.0),
        (RATE, 1, 1.0),
        (RATE, '1e3', 1000.0),  # YAML 1.1 reads 1e3 as text
        (BITS, 8, 8),
        (BITS, 8.0, 8),
        (FLAG, False, False),
        (KIND, 'sweep', 'sweep'),
        (TITLE, 'any', 'any'),
    ],
)
def test_values_become_the_declared_type(parameter, value, converted):
    got = parameter.convert(value)
    assert got == converted
    assert type(got) is parameter.kind


@pytest.mark.parametrize(
    ('parameter', 'value'),
    [
        *((RATE, value) for value in (True, None, 'fast', [1.0], {'a': 1}, 1j, 10**400)),
        *((BITS, value) for value in (True, None, '8', 8.5, math.nan, math.inf, [8])),
        *((FLAG, value) for value in (1, 0, 'true', None)),
        *((KIND, value) for value in (True, 1, None)),
        (TITLE, 3.0),
    ],
)
def test_a_wrong_type_is_refused(parameter, value):
    kind = parameter.kind.__name__
    with pytest.raises(
        InputError, match=rf'{parameter.name} = .* has the wrong type; give a {kind}'
    ):
        parameter.convert(value)


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf, 'nan', 'inf', '-inf', '1e999'])
def test_what_is_not_finite_is_refused(value):
    with pytest.raises(InputError, match=r'run\.rate = .* is not finite; give a float in Hz, >= 1'):
        RATE.convert(value)


@pytest.mark.parametrize(
    ('parameter', 'value'),
    [
        *((RATE, value) for value in (0, 0.999, -5.0, 100_001.0)),
        *((BITS, value) for value in (3, 33, -16, 10**400)),
        *((DEPTH, value) for value in (0.0, 0, -1.0, -0.0)),
    ],
)
def test_what_is_out_of_range_is_refused(parameter, value):
    with pytest.raises(InputError, match=rf'{parameter.name} = .* is out of range; give a'):
        parameter.convert(value)


def test_an_unknown_choice_names_the_nearest_and_all():
    with pytest.raises(InputError, match=r"'swep' is unknown \(did you mean 'sweep'\?\); give one"):
        KIND.convert('swep')


@every_parameter
def test_each_bound_is_kept(parameter):
    if parameter.kind is not float:
        return
    if parameter.minimum > -math.inf:
        with pytest.raises(InputError, match='is out of range'):
            parameter.convert(math.nextafter(parameter.minimum, -math.inf))
        if parameter.above:
            with pytest.raises(InputError, match='is out of range'):
                parameter.convert(parameter.minimum)
        else:
            assert parameter.convert(parameter.minimum) == parameter.minimum
    if parameter.maximum < math.inf:
        assert parameter.convert(parameter.maximum) == parameter.maximum
        with pytest.raises(InputError, match='is out of range'):
            parameter.convert(math.nextafter(parameter.maximum, math.inf))


# --- specs ---


@pytest.mark.parametrize(
    ('name', 'hint', 'listed'),
    [
        ('platform.k11', "did you mean 'platform.k1'", 'platform.L20'),
        ('excitation.kinds', "did you mean 'excitation.kind'", 'excitation.ramp'),
        ('analyser.estimator', "did you mean 'analyzer.estimator'", r'analyzer\.\*'),
        ('rate', 'known', r'run\.\*'),
        ('platform', "did you mean 'platform.m'", r'platform\.L20'),
    ],
)
def test_a_misspelt_key_names_the_nearest_and_lists_the_known(name, hint, listed):
    with pytest.raises(InputError, match=rf'unknown parameter {name!r}.*{hint}.*{listed}'):
        scenario.of({name: 1.0})


def test_a_spec_is_complete_and_leaves_out_what_nobody_set():
    spec = scenario.of({'run.rate': 250})
    assert spec['run.rate'] == 250.0
    assert spec['platform.k1'] == 20000.0
    assert 'platform.A' not in spec
    assert spec.optional('platform.A') is None
    assert len(spec) == len(list(spec)) == len(set(spec))
    with pytest.raises(KeyError, match=r'platform\.A'):
        spec['platform.A']
    assert set(spec.sections('run', 'shaker')) == {
        name for name in spec if name.startswith(('run.', 'shaker.'))
    }


def test_typed_reading():
    spec = scenario.of({})
    assert spec.number('run.rate') == 500.0
    assert spec.count('run.seed') == 0
    assert spec.text('run.mode') == 'lockstep'
    assert spec.flag('shaker.limits') is True


@pytest.mark.parametrize(
    ('one', 'other'),
    [
        (parameter.name, other)
        for parameter in scenario.parameters()
        for other in parameter.replaces
    ],
)
def test_synonyms_exclude_each_other_and_the_later_layer_wins(one, other):
    values = {one: 0.5, other: 0.25}
    for order in (values, dict(reversed(values.items()))):
        with pytest.raises(InputError, match='say the same thing twice; keep one of them'):
            scenario.of(order)
    later = scenario.of({other: 0.25}).override({one: 0.5})
    assert dict(later.given) == {one: 0.5}
    back = later.override({other: 0.125})
    assert dict(back.given) == {other: 0.125}


def test_a_refused_override_leaves_the_spec_alone():
    spec = scenario.of({'run.rate': 250.0})
    with pytest.raises(InputError, match='out of range'):
        spec.override({'run.seed': 3, 'run.rate': -1.0})
    assert dict(spec.given) == {'run.rate': 250.0}


# --- YAML ---


def write(tmp_path, text):
    path = tmp_path / 'some.yaml'
    path.write_text(text, encoding='utf-8')
    return path


def ros(body):
    return '/**:\n  ros__parameters:\n' + body


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', 'is no ROS parameter file; it starts with'),
        ('[1, 2]', 'is no ROS parameter file'),
        ('just words', 'is no ROS parameter file'),
        ('{}', 'is no ROS parameter file'),
        ('/**: 3', r"node '/\*\*' must hold ros__parameters and nothing else"),
        ('platform: {k1: 3}', "node 'platform' must hold ros__parameters"),
        ('/**: {ros__parameters: {}, more: 1}', 'nothing else'),
        ('/**: {ros__parameters: 3}', 'ros__parameters must map names to values'),
        ('/**: {ros__parameters: [1]}', 'ros__parameters must map names to values'),
        ('a: b: c', 'is not YAML: mapping values'),
        (ros('    run.rate: 2001-99-99\n'), 'is not YAML: month must be in'),
        ('/**: !!python/object:os.system {}', 'is not YAML'),
        (
            ros('    run.rate: 1.0\n    run: {rate: 2.0}\n'),
            'run.rate is given twice with different values',
        ),
        (
            'a: {ros__parameters: {run: {seed: 1}}}\nb: {ros__parameters: {run: {seed: 2}}}',
            'run.seed is given twice',
        ),
    ],
)
def test_a_file_of_another_shape_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_yaml(write(tmp_path, text))


def test_a_key_repeated_in_one_map_is_refused(tmp_path):
    text = ros('    platform:\n      k1: 1.0\n      k2: 3.0\n      k1: 2.0\n')
    with pytest.raises(InputError, match="line 6: 'k1' is given twice; keep one"):
        read_yaml(write(tmp_path, text))


def test_a_file_that_is_not_there_or_no_text_is_refused(tmp_path):
    with pytest.raises(InputError, match=r'nowhere\.yaml cannot be read: No such file'):
        read_yaml(tmp_path / 'nowhere.yaml')
    with pytest.raises(InputError, match='cannot be read: Is a directory'):
        read_yaml(tmp_path)
    (tmp_path / 'binary.yaml').write_bytes(b'\xff\xfe\x00\x80')
    with pytest.raises(InputError, match='is not YAML'):
        read_yaml(tmp_path / 'binary.yaml')


def test_nested_and_dotted_keys_and_several_nodes_read_the_same(tmp_path):
    nested = read_yaml(write(tmp_path, ros('    run:\n      rate: 3.0\n    platform.k1: 5\n')))
    assert nested == {'run.rate': 3.0, 'platform.k1': 5}
    spread = 'a: {ros__parameters: {run: {rate: 3.0}}}\nb: {ros__parameters: {platform.k1: 5}}'
    assert read_yaml(write(tmp_path, spread)) == nested
    assert read_yaml(write(tmp_path, '/**: {ros__parameters: }')) == {}


def test_a_file_may_merge_its_own_anchors(tmp_path):
    text = 'a: {ros__parameters: &p {run.rate: 5.0}}\nb: {ros__parameters: {<<: *p, run.seed: 1}}'
    assert read_yaml(write(tmp_path, text)) == {'run.rate': 5.0, 'run.seed': 1}


def a_value(parameter):
    if parameter.choices:
        return st.sampled_from(parameter.choices)
    if parameter.kind is bool:
        return st.booleans()
    if parameter.kind is str:
        return st.text(st.characters(codec='utf-8', exclude_categories=('Cs',)), max_size=12)
    if parameter.kind is int:
        return st.integers(int(parameter.minimum), int(parameter.maximum))
    return st.floats(
        parameter.minimum if parameter.minimum > -math.inf else None,
        parameter.maximum if parameter.maximum < math.inf else None,
        allow_nan=False,
        allow_infinity=False,
        exclude_min=parameter.above,
    )


ONE_WORD = [p for p in scenario.parameters() if not p.replaces]
"""Without synonyms, so that any set of them may stand together."""


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.fixed_dictionaries({}, optional={p.name: a_value(p) for p in ONE_WORD}))
def test_a_spec_survives_its_yaml(tmp_path_factory, given_values):
    spec = scenario.of(given_values)
    path = tmp_path_factory.mktemp('yaml') / 'spec.yaml'
    path.write_text(spec.to_yaml(), encoding='utf-8')
    again = RunSpec.of(scenario.parameters(), read_yaml(path))
    assert dict(again) == dict(spec)
    # rcl takes no empty map: a spec of defaults writes one of them out
    assert dict(again.given) == (dict(spec.given) or {'run.rate': 500.0})


@pytest.mark.parametrize(
    ('text', 'name', 'value'),
    [
        ('platform.k1=20000', 'platform.k1', 20000),
        (' shaker.limits = false', 'shaker.limits', False),
        ('run.mode=real_time', 'run.mode', 'real_time'),
        ('analyzer.top.topic=a=b', 'analyzer.top.topic', 'a=b'),
        ('platform.zeta=1e-3', 'platform.zeta', '1e-3'),
        ('run.seed=', 'run.seed', None),
    ],
)
def test_an_assignment(text, name, value):
    assert parse_assignment(text) == (name, value)


@pytest.mark.parametrize('text', ['platform.k1', '', '=3', '  =3'])
def test_what_is_no_assignment_is_refused(text):
    with pytest.raises(
        InputError, match=r'--set .* is not an assignment; write --set platform\.k1'
    ):
        parse_assignment(text)


@pytest.mark.parametrize('value', ['[1', '2001-99-99', '@'])
def test_an_assignment_of_what_is_not_yaml_is_refused(value):
    with pytest.raises(InputError, match=r"--set 'run\.rate=.*': the value is not YAML"):
        parse_assignment(f'run.rate={value}')
