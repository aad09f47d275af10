"""The page of a run, in a real browser; how the page itself works is tested in test/compare."""

from __future__ import annotations

from browsing import opened, renderers, started
from ros_support import SHORT, given


def test_page_of_a_run(lab):
    command = lab.cli('run', *given(SHORT), '--out', str(lab.folder / 'out'), '--no-bag')
    assert command.code() == 0, command.log
    browser = started(lab.folder / 'profile')
    try:
        page = opened(browser, lab.folder / 'out' / 'report.html')
        names = [r['name'] for r in renderers(page) if r['n'] > 5]
        text = page.find_element('tag name', 'body').text
    finally:
        browser.quit()
    assert any('forward' in name for name in names) and any('reverse' in name for name in names)
    assert any('theory' in name for name in names)
    assert 'lost samples' in text and 'corrected' in text
