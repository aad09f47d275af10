"""The report in a real browser: what it draws, what its tables say, what it must not run."""

from __future__ import annotations

import builtins
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from browsing import opened, renderers, started
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from qzs_rig.compare import compare
from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Estimate, Event
from qzs_rig.report.run_page import events_table, report_page, write_report

HOSTILE = '</script><img src=x onerror="document.title=1"><b>&amp;'


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    driver = started(tmp_path_factory.mktemp('profile'))
    yield driver
    driver.quit()


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
    magnitude, phase, thd = (renderers(page, panel) for panel in range(3))
    # per direction: curve, interval, arrows and three kinds of event, too many points for dots
    assert sum('theory' not in r['name'] for r in magnitude) == 2 * 6
    # theory: stable and unstable, T and phase, and the folds of either kind
    theory_drawn = [r for r in magnitude if 'theory' in r['name']]
    assert [r['dash'] for r in theory_drawn if r['kind'] == 'Line'] == [[], [6, 3]]
    assert [r['dash'] for r in phase if 'theory' in r['name']] == [[], [6, 3]]
    assert [len(phase), len(thd)] == [2 + 2, 2]
    assert all(r['visible'] and r['n'] > 1 for r in (*phase, *thd))

    header, forward, reverse = cells(page)
    assert header[2:] == ['onset Hz', 'peak Hz', 'peak T', 'jump up Hz', 'jump down Hz', '± Hz']
    found = {(e.direction, e.kind): e for e in run.events}
    assert forward[:2] == ['vertical', 'forward']
    assert forward[3] == f'{found["forward", "peak"].frequency_hz:.3f}'
    assert forward[4] == f'{found["forward", "peak"].magnitude:.3f}'
    assert forward[5] == '–' and reverse[6] == '–'
    assert reverse[5] == f'{found["reverse", "jump_up"].frequency_hz:.3f}'

    assert [(r['name'], r['n']) for r in magnitude if 'folds' in r['name']] == [
        ('theory, one harmonic, folds', 1)
    ] * 2
    low, high = theory.folds
    notes = [note for r in magnitude if 'folds' in r['name'] for note in r['note']]
    assert notes[0].startswith(f'jump up at {low.frequency_hz:.4f} Hz from T = ')
    assert notes[1].endswith(f'to T = {high.transmissibility[1]:.4g} on the lower branch')
    points = magnitude[0]['note']
    assert points[0].startswith('upper branch, z = ')
    assert points[-1].startswith('lower branch, z = ')
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
    tools = page.execute_script(
        "return document.querySelector('.plot').plot.toolbar.tools.map(t => t.type)"
    )
    assert set(tools) == {
        'BoxZoomTool',
        'PanTool',
        'WheelZoomTool',
        'SaveTool',
        'ResetTool',
        'HoverTool',
    }


POINT = """
const place = document.querySelector('.plot');
const view = Bokeh.index.find_one(place.plot);
const source = place.plot.renderers[0].data_source;
const k = 40, box = place.getBoundingClientRect();
const area = view.frame.bbox;
return [box.x + area.x + view.frame.x_scale.compute(source.get('x')[k]) - area.x,
        box.y + area.y + view.frame.y_scale.compute(source.get('y')[k]) - area.y]
"""
TOOLTIPS = """
const texts = [];
(function walk(node) {
  for (const child of node.querySelectorAll('*')) {
    if (child.matches('.bk-Tooltip') && child.shadowRoot) {
      texts.push(child.shadowRoot.textContent);
    }
    if (child.shadowRoot) { walk(child.shadowRoot); }
  }
})(document);
return texts
"""


def test_a_point_says_what_it_is(browser, run, theory, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'hover', [('run 1', run)], theory=[theory])
    page = opened(browser, path)
    page.execute_script("document.querySelector('.plot').scrollIntoView({block: 'center'})")
    x, y = page.execute_script(POINT)
    page.execute_script('window.scrollTo(0, window.scrollY)')
    ActionChains(page).move_by_offset(int(x), int(y)).perform()
    said = WebDriverWait(page, 10).until(lambda p: ''.join(p.execute_script(TOOLTIPS)))
    assert 'forward' in said and 'frequency, Hz' in said and 'upper branch, z = ' in said


def test_a_name_hides_its_curves(browser, run, theory, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'key', [('run 1', run)], theory=[theory])
    page = opened(browser, path)
    names = [b.text for b in page.find_elements(By.CSS_SELECTOR, 'figcaption button')]
    assert [name.lstrip('↑ ') for name in names] == [
        'forward',
        'reverse',
        'theory, one harmonic',
        'theory, one harmonic, unstable',
        'theory, one harmonic, folds',
    ]
    button = page.find_element(By.CSS_SELECTOR, 'button[data-label=forward]')
    for shown in (False, True):
        button.click()
        assert button.get_attribute('aria-pressed') == str(shown).lower()
        for panel in range(3):
            for r in renderers(page, panel):
                assert r['visible'] == (shown or r['name'] != 'forward')


def test_axes_say_what_they_show(browser, run, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'axes', [('run', run)])
    page = opened(browser, path)
    axes = page.execute_script(
        "return [...document.querySelectorAll('.plot')].map(({plot}) =>"
        ' [plot.left[0].axis_label, plot.y_scale.type, plot.below[0].axis_label,'
        " plot.center.filter(c => c.type === 'Span').map(c => c.location)])"
    )
    assert axes == [
        ['|T|, top / base', 'LogScale', '', [1]],
        ['phase, °', 'LinearScale', '', []],
        ['THD, %', 'LinearScale', 'frequency, Hz', []],
    ]
    shared = page.execute_script(
        "return new Set([...document.querySelectorAll('.plot')].map(p => p.plot.x_range)).size"
    )
    assert shared == 1


def test_comparison_of_two_runs(browser, run, stiffer_run, tmp_path):
    runs = [('calm', run), ('strong', stiffer_run)]
    comparison = compare(runs)
    path = tmp_path / 'report.html'
    write_report(path, 'calm against strong', runs, tables=comparison.tables())
    page = opened(browser, path)
    assert [len(renderers(page, panel)) for panel in range(3)] == [2 * 2 * 6, 2 * 2, 2 * 2]
    assert {r['name'] for r in renderers(page)} >= {'calm, forward', 'strong, reverse'}
    assert len(cells(page, 0)) == 1 + 4
    assert cells(page, 1)[1][:5] == ['vertical', 'forward', 'isolation onset', 'calm', 'strong']


TOUCH_ACTIONS = """
const found = [];
(function walk(node) {
  for (const child of node.querySelectorAll('*')) {
    if (child.matches('.bk-events')) { found.push(getComputedStyle(child).touchAction); }
    if (child.shadowRoot) { walk(child.shadowRoot); }
  }
})(document);
return found
"""


def test_page_fits_a_phone(browser, run, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'phone', [('run', run)])
    browser.execute_cdp_cmd(
        'Emulation.setDeviceMetricsOverride',
        {'width': 390, 'height': 844, 'deviceScaleFactor': 2, 'mobile': True},
    )
    browser.execute_cdp_cmd('Emulation.setTouchEmulationEnabled', {'enabled': True})
    try:
        page = opened(browser, path)
        widths = page.execute_script(
            'return [document.documentElement.scrollWidth,'
            " Bokeh.index.find_one(document.querySelector('.plot').plot).el.offsetWidth]"
        )
        touched = page.execute_script(TOUCH_ACTIONS)
    finally:
        browser.execute_cdp_cmd('Emulation.setTouchEmulationEnabled', {'enabled': False})
        browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})
    assert widths[0] <= 390
    assert 300 < widths[1] <= 390
    # a finger on the curves scrolls the page
    assert touched == ['auto'] * 3


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
    button = page.find_element(By.CSS_SELECTOR, 'figcaption button')
    assert button.get_attribute('data-label') == HOSTILE
    assert button.text == HOSTILE
    assert renderers(page)[0]['name'] == HOSTILE


def test_page_refers_to_nothing_outside(run):
    page = report_page('outside', [('run', run)])
    markup = re.sub(r'<script.*?</script>', '', page, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!#|data:)[^"]*"', markup) == []
    assert "default-src 'none'" in markup
    assert report_page('outside', [('run', run)]) == page


def test_page_fetches_nothing(browser, run, tmp_path):
    path = tmp_path / 'report.html'
    write_report(path, 'alone', [('run', run)])
    browser.get_log('performance')
    opened(browser, path)
    events = (json.loads(entry['message'])['message'] for entry in browser.get_log('performance'))
    urls = [
        e['params']['request']['url'] for e in events if e['method'] == 'Network.requestWillBeSent'
    ]
    assert [url for url in urls if not url.startswith(('data:', 'blob:'))] == [path.as_uri()]


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
    assert [r['n'] for r in renderers(page)] == [3, 3]
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


def test_missing_bokeh_is_named(run, tmp_path, monkeypatch):
    whole = builtins.__import__

    def without(name, *rest):
        if name.startswith('bokeh'):
            raise ImportError(name)
        return whole(name, *rest)

    monkeypatch.setattr(builtins, '__import__', without)
    with pytest.raises(InputError, match='pip install bokeh'):
        write_report(tmp_path / 'report.html', 'no bokeh', [('run', run)])
    assert list(tmp_path.iterdir()) == []


def test_event_table_for_the_terminal(run):
    lines = events_table([('run', run)]).to_text().splitlines()
    assert lines[0] == 'Isolation onset (T = 1), peak and jumps'
    assert lines[3].split()[:2] == ['vertical', 'forward']
    assert len({len(line) for line in lines[1:3]}) == 1
    assert events_table([('a', run), ('b', run)]).header[0] == 'run'
