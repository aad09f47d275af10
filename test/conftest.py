"""Puts this folder on the path, so that tests in all folders share `ros_support`."""

import os

import pytest
from hypothesis import settings

# the same examples in every CI run: a new counterexample is for somebody who can look at it
settings.register_profile('ci', derandomize=True)
if os.environ.get('CI'):
    settings.load_profile('ci')


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """A failed test with real processes shows what each of them said."""
    report = yield
    if report.when == 'call' and report.failed:
        for lab in item.funcargs.values():
            for process in getattr(lab, 'processes', ()):
                state = 'still running' if process.running else 'ended'
                report.sections.append((f'{process.name}, {state}, said', process.log))
    return report
