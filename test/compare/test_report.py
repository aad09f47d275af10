"""The report in a real browser: what it draws, what its tables say, what it must not run."""

from __future__ import annotations

import builtins
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from qzs_rig.compare.match import compare
from qzs_rig.compare.report import event_table, report_page, write_report
from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Estimate, Event

HOSTILE = '</script><img src=x onerror="document.title=1"><b>&amp;'


def program(name):
    path = shutil.which(name)
    if path is None:
        pytest.fail(
            f'{name} is missing: the report is tested in a real browser; '
            'install it with: apt-get install chromium chromium-driver'
        )
    return path


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    options = Options()
    options.binary_location = program('chromium')
    for flag in (
        '--headless',
        '--no-sandbox',
        '--disable-gpu',
        '--disable-quic',
        '--no-first-run',
        '--disable-background-networking',
        '--disable-component-update',
        '--disable-sync',
        '--window-size=1920,1080',
        f'--user-data-dir={tmp_path_factory.mktemp("profile")}',
    ):
        options.add_argument(flag)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    driver = webdriver.Chrome(options=options, service=Service(program('chromedriver')))
    yield driver
    driver.quit()


def opened(browser, path):
    """Open `path` from the disk and wait until every figure is drawn."""
    browser.get(path.as_uri())
    figures = "return [...document.querySelectorAll('.plot')].every(p => p.dataset.ready)"
    WebDriverWait(browser, 15).until(lambda driver: driver.execute_script(figures))
    assert browser.get_log('browser') == []
    return browser


def traces(browser, figure=0):
    script = (
        "return document.querySelectorAll('.plot')[arguments[0]].data.map(t =>"
        " ({name: t.name, axis: t.yaxis || 'y', mode: t.mode, n: t.x.length,"
        ' dash: t.line && t.line.dash}))'
    )
    return browser.execute_script(script, figure)


def cells(browser, table=0):
    rows = browser.find_elements(By.TAG_NAME, 'table')[table].find_elements(By.TAG_NAME, 'tr')
    return [[c.text for c in row.find_elements(By.CSS_SELECTOR, 'th,td')] for row in rows]


def test_one_run_with_theory(browser, run, theory, tmp_path):
    path = tmp_path / 'new' / 'report.html'
    facts = [('law', 'corrected'), ('lost samples', '0')]
    tables = compare([('run 1', run)], [theory]).tables()
    write_report(
        path, 'Vertical sweep', [('run 1', run)], theory=[theory], facts=facts, tables=tables
    )
    page = opened(browser, path)

    assert page.title == 'Vertical sweep'
    drawn = traces(page)
    # Per direction: magnitude, phase, THD and events; theory: stable and unstable, T and phase,
    # and the folds.
    assert len(drawn) == 2 * 4 + 2 * 2 + 1
    assert sum(trace['axis'] == 'y3' for trace in drawn) == 2
    assert [t['dash'] for t in drawn if 'theory' in t['name'] and t['dash']] == ['solid'] * 2 + [
        '5px,4px'
    ] * 2
    assert len(page.find_elements(By.CSS_SELECTOR, '.plot path.js-line')) >= 10

    header, forward, reverse = cells(page)
    assert header[2:] == ['onset Hz', 'peak Hz', 'peak T', 'jump up Hz', 'jump down Hz', '± Hz']
    found = {(e.direction, e.kind): e for e in run.events}
    assert forward[:2] == ['vertical', 'forward']
    assert forward[3] == f'{found["forward", "peak"].frequency_hz:.3f}'
    assert forward[4] == f'{found["forward", "peak"].magnitude:.3f}'
    assert forward[5] == '–' and reverse[6] == '–'
    assert reverse[5] == f'{found["reverse", "jump_up"].frequency_hz:.3f}'

    assert [(t['name'], t['n']) for t in drawn if 'folds' in t['name']] == [
        ('theory, one harmonic, folds', 2)
    ]
    hover = page.execute_script(
        "return document.querySelector('.plot').data.find(t => t.name.includes('folds')).text"
    )
    low, high = theory.folds
    assert hover[0].startswith(f'jump up at {low.frequency_hz:.4f} Hz from T = ')
    assert hover[1].endswith(f'to T = {high.transmissibility[1]:.4g} on the lower branch')
    points = page.execute_script("return document.querySelector('.plot').data[0].text")
    assert points[0].startswith('<br>upper branch, z = ')
    assert points[-1].startswith('<br>lower branch, z = ')
    header, forward, reverse = cells(page, 1)
    assert header[-2:] == ['within 2σ', 'remark'] and forward[-2] == reverse[-2] == '240'
    assert re.fullmatch(
        r'(\d+) of \1 points within 2σ of the lower branch, '
        r'(\d+) of \2 points within 2σ of the upper branch',
        forward[-1],
    )

    facts_shown = page.find_element(By.TAG_NAME, 'dl').text.split('\n')
    assert facts_shown == ['law', 'corrected', 'lost samples', '0']
    spoken = page.find_element(By.CSS_SELECTOR, '.plot').get_attribute('aria-label')
    assert 'Forward: isolation onset at' in spoken
    buttons = page.execute_script(
        "return [...document.querySelectorAll('.modebar-btn')].map(b => b.dataset.title)"
    )
    assert not [title for title in buttons if 'hare' in title or 'loud' in title]


def test_axes_say_what_they_show(browser, run, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'axes', [('run', run)])
    page = opened(browser, path)
    layout = page.execute_script(
        "const l = document.querySelector('.plot').layout;"
        'return [l.xaxis.title.text, l.yaxis.title.text, l.yaxis.type, l.yaxis2.title.text,'
        ' l.yaxis3.title.text, l.shapes[0].y0]'
    )
    assert layout == ['frequency, Hz', '|T|, top / base', 'log', 'phase, °', 'THD, %', 1]


def test_comparison_of_two_runs(browser, run, stiffer_run, tmp_path):
    runs = [('calm', run), ('strong', stiffer_run)]
    comparison = compare(runs)
    path = tmp_path / 'report.html'
    write_report(path, 'calm against strong', runs, tables=comparison.tables())
    page = opened(browser, path)
    assert len(traces(page)) == 2 * 2 * 4
    assert {t['name'] for t in traces(page)} >= {'calm, forward', 'strong, reverse'}
    assert len(cells(page, 0)) == 1 + 4
    assert cells(page, 1)[1][:5] == ['vertical', 'forward', 'isolation onset', 'calm', 'strong']


def test_page_fits_a_phone(browser, run, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'phone', [('run', run)])
    browser.execute_cdp_cmd(
        'Emulation.setDeviceMetricsOverride',
        {'width': 390, 'height': 844, 'deviceScaleFactor': 2, 'mobile': True},
    )
    try:
        page = opened(browser, path)
        widths = page.execute_script(
            'return [document.documentElement.scrollWidth,'
            " document.querySelector('.plot svg').getBoundingClientRect().width]"
        )
    finally:
        browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})
    assert widths[0] <= 390
    assert 300 < widths[1] <= 390


def test_foreign_text_stays_text(browser, run, tmp_path):
    """Names in a foreign bag are shown, never run; the page's policy allows no other script."""
    hostile = Estimate(
        tuple(replace(c, dof=HOSTILE, direction=HOSTILE, estimator=HOSTILE) for c in run.curves),
        (Event(HOSTILE, HOSTILE, HOSTILE, 1.0, 1.0, 0.1),),
        {HOSTILE: HOSTILE},
    )
    path = tmp_path / 'report.html'
    write_report(path, HOSTILE, [(HOSTILE, hostile)], facts=[(HOSTILE, HOSTILE)])
    page = opened(browser, path)
    assert page.title == HOSTILE
    assert page.find_element(By.TAG_NAME, 'h1').text == HOSTILE
    assert page.find_elements(By.CSS_SELECTOR, 'img[src=x], main b') == []
    assert cells(page)[1][0] == HOSTILE
    legend = page.execute_script("return document.querySelector('.legendtext').textContent")
    assert legend == HOSTILE


def test_page_refers_to_nothing_outside(run):
    page = report_page('outside', [('run', run)])
    markup = re.sub(r'<script.*?</script>', '', page, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!#|data:)[^"]*"', markup) == []
    assert "default-src 'none'" in markup
    assert report_page('outside', [('run', run)]) == page


def test_curve_without_usable_points_is_drawn_empty(browser, run, tmp_path):
    nothing = np.full(3, np.nan)
    curve = replace(
        run.curves[0],
        frequency_hz=np.arange(3.0),
        magnitude=nothing,
        phase_deg=nothing,
        thd=nothing,
    )
    path = tmp_path / 'report.html'
    write_report(path, 'empty', [('run', Estimate((curve,))), ('none', Estimate())])
    page = opened(browser, path)
    assert len(traces(page)) == 2
    assert 'no onset, peak or jump found' in page.find_element(By.TAG_NAME, 'main').text


def test_refuses_to_overwrite(run, tmp_path):
    path = tmp_path / 'report.html'
    path.write_text('mine')
    with pytest.raises(InputError, match=r'report\.html is already there; .* --out'):
        write_report(path, 'again', [('run', run)])
    assert path.read_text() == 'mine'
    assert [item.name for item in tmp_path.iterdir()] == ['report.html']


def test_refuses_a_folder_that_cannot_be(run, tmp_path):
    (tmp_path / 'file').write_text('')
    with pytest.raises(InputError, match=r'cannot write .* give another --out'):
        write_report(tmp_path / 'file' / 'report.html', 'no', [('run', run)])


def test_missing_plotly_is_named(run, tmp_path, monkeypatch):
    whole = builtins.__import__

    def without(name, *rest):
        if name.startswith('plotly'):
            raise ImportError(name)
        return whole(name, *rest)

    monkeypatch.setattr(builtins, '__import__', without)
    with pytest.raises(InputError, match='pip install plotly'):
        write_report(tmp_path / 'report.html', 'no plotly', [('run', run)])
    assert list(tmp_path.iterdir()) == []


def test_event_table_for_the_terminal(run):
    lines = event_table([('run', run)]).splitlines()
    assert lines[0] == 'Isolation onset (T = 1), peak and jumps'
    assert lines[3].split()[:2] == ['vertical', 'forward']
    assert len({len(line) for line in lines[1:3]}) == 1
    assert event_table([('a', run), ('b', run)]).splitlines()[1].startswith('run')
