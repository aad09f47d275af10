"""The page of a run, in a real browser; how the page itself works is tested in test/compare."""

from __future__ import annotations

import shutil

from ros_support import SHORT, given
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

FLAGS = (
    *('--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run'),
    *('--disable-background-networking', '--disable-component-update', '--disable-sync'),
)


def test_page_of_a_run(lab):
    command = lab.cli('run', *given(SHORT), '--out', str(lab.folder / 'out'), '--no-bag')
    assert command.code() == 0, command.log
    options = Options()
    options.binary_location = shutil.which('chromium') or ''
    assert options.binary_location, 'chromium is missing: apt-get install chromium chromium-driver'
    for flag in (*FLAGS, f'--user-data-dir={lab.folder / "profile"}'):
        options.add_argument(flag)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    browser = webdriver.Chrome(options=options, service=Service(shutil.which('chromedriver')))
    try:
        browser.get((lab.folder / 'out' / 'report.html').as_uri())
        ready = "return [...document.querySelectorAll('.plot')].every(p => p.dataset.ready)"
        WebDriverWait(browser, 30).until(lambda driver: driver.execute_script(ready))
        assert browser.get_log('browser') == []
        names = browser.execute_script(
            "return [...document.querySelectorAll('.plot')].flatMap(p => p.data)"
            '.filter(t => t.x.length > 5).map(t => t.name)'
        )
        text = browser.find_element('tag name', 'body').text
    finally:
        browser.quit()
    assert any('forward' in name for name in names) and any('reverse' in name for name in names)
    assert any('theory' in name for name in names)
    assert 'lost samples' in text and 'corrected' in text
