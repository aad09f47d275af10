"""Pages in a real browser."""

from __future__ import annotations

import shutil

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

FLAGS = (
    *('--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run'),
    *('--disable-background-networking', '--disable-component-update', '--disable-sync'),
    '--window-size=1920,1080',
)

RENDERERS = """
return document.querySelectorAll('.plot')[arguments[0]].plot.renderers.map(r => ({
  name: r.name, kind: r.glyph.type, visible: r.visible,
  n: 'x' in r.glyph && r.data_source.columns().includes('x') ? r.data_source.get('x').length : 0,
  note: r.data_source.columns().includes('note') ? Array.from(r.data_source.get('note')) : [],
  dash: r.glyph.line_dash ? r.glyph.line_dash.value : null}))
"""


def program(name):
    path = shutil.which(name)
    if path is None:
        pytest.fail(
            f'{name} is missing: pages are tested in a real browser; '
            'install it with: apt-get install chromium chromium-driver'
        )
    return path


def started(profile):
    """A browser whose `profile` is an empty folder."""
    options = Options()
    options.binary_location = program('chromium')
    for flag in (*FLAGS, f'--user-data-dir={profile}'):
        options.add_argument(flag)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
    return webdriver.Chrome(options=options, service=Service(program('chromedriver')))


def opened(browser, path):
    """Open `path` from the disk and wait until every figure is drawn."""
    browser.get(path.as_uri())
    figures = "return [...document.querySelectorAll('.plot')].every(p => p.dataset.ready)"
    WebDriverWait(browser, 30).until(lambda driver: driver.execute_script(figures))
    assert browser.get_log('browser') == []
    return browser


def renderers(browser, panel=0):
    """What a panel has drawn: name, kind, visible, number of points, notes, dashes of each."""
    return browser.execute_script(RENDERERS, panel)
