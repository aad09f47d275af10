"""A sheet of every kind of thing, drawn still and interactive."""

from __future__ import annotations

import numpy as np
import pytest
from browsing import opened, renderers, started

from qzs_rig.report.sheet import Band, Curve, Panel, Points, Regions, Shades, Sheet, key
from qzs_rig.report.still import still
from qzs_rig.report.write import write_page

X = np.linspace(1.0, 10.0, 40)
Y = np.where(X > 5.0, X, np.nan)
GRID = np.arange(12.0).reshape(3, 4)
NAMES = {0: ('left', '#0b62a4'), 1: ('right', '#c2410c')}

EVERYTHING = Sheet(
    'everything',
    'Everything',
    'what there is',
    (
        Panel('lines', 'x', 'y', (Curve('a', X, Y), Band('a', X, Y - 1, Y + 1)), 'xy', 1.0),
        Panel('marks', 'x', 'y', (Points('b', X, Y, mark='up', hollow=True),), 'x'),
        Panel('regions', 'x', 'y', (Regions(X, X, np.eye(40, dtype=np.int64), NAMES),)),
        Panel('map', 'x', 'y', (Shades(np.arange(4.0), np.arange(3.0), GRID),)),
        Panel('dots', 'x', 'y', (Shades(X, X, X),)),
    ),
    columns=2,
)


@pytest.mark.parametrize('kind', ['svg', 'png'])
def test_the_same_sheet_gives_the_same_picture(kind):
    assert still(EVERYTHING, kind) == still(EVERYTHING, kind)


def test_a_label_is_in_the_key_once():
    lines, _, regions, shades, _ = EVERYTHING.panels
    assert [entry.label for entry in key(lines)] == ['a']
    assert [entry.label for entry in key(lines, regions)] == ['a', 'left', 'right']
    assert key(shades) == []
    assert not EVERYTHING.one_key


def test_everything_is_drawn_in_a_page(tmp_path):
    path = write_page(tmp_path / 'page.html', 'Everything', [EVERYTHING])
    browser = started(tmp_path / 'profile')
    try:
        page = opened(browser, path)
        kinds = [[r['kind'] for r in renderers(page, panel)] for panel in range(5)]
        shown = [[r['visible'] for r in renderers(page, 2)]]
        page.find_element('css selector', 'button[data-label=left]').click()
        shown.append([r['visible'] for r in renderers(page, 2)])
    finally:
        browser.quit()
    assert kinds == [
        ['Line', 'VArea'],
        ['Scatter'],
        ['ImageRGBA', 'ImageRGBA'],
        ['Scatter'],
        ['Scatter'],
    ]
    assert shown == [[True, True], [False, True]]
