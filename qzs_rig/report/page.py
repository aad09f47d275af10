"""A page of text, tables and sheets in one file that needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from html import escape

from qzs_rig.report.interactive import drawing, javascript, place_ids
from qzs_rig.report.sheet import MARKS, Entry, Panel, Sheet, key
from qzs_rig.report.skin import BOOT, STYLE
from qzs_rig.report.table import Table

Part = str | Table | Sheet
"""Of a page; a str is HTML that is escaped already."""


def page(title: str, parts: Sequence[Part]) -> str:
    """The page of `parts` in order. The same parts give the same text.

    Raises InputError where Bokeh is not installed.
    """
    bokeh = javascript()
    sheets = [part for part in parts if isinstance(part, Sheet)]
    # "<" would let a label end the script element; JSON may spell it as an escape
    data = json.dumps(drawing(sheets), allow_nan=False, separators=(',', ':')).replace(
        '<', '\\u003c'
    )
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_policy(bokeh, BOOT)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>{STYLE}</style>
</head>
<body>
<main>
{''.join(map(_section, parts))}</main>
<script type="application/json" id="drawing">{data}</script>
<script>{bokeh}</script>
<script>{BOOT}</script>
</body>
</html>
"""


def header(
    title: str,
    facts: Sequence[tuple[str, str]] = (),
    subtitle: str = '',
    sheets: Sequence[Sheet] = (),
) -> str:
    """Title, subtitle and facts, and links to `sheets` where there are several."""
    items = ''.join(
        f'<div><dt>{escape(name)}</dt><dd>{escape(text)}</dd></div>' for name, text in facts
    )
    links = ''.join(f'<a href="#{sheet.name}">{escape(sheet.title)}</a>' for sheet in sheets)
    return (
        f'<header><h1>{escape(title)}</h1>'
        + (f'<p class="runs">{escape(subtitle)}</p>' if subtitle else '')
        + (f'<dl>{items}</dl>' if facts else '')
        + (f'<nav aria-label="figures">{links}</nav>' if len(sheets) > 1 else '')
        + '</header>\n'
    )


def footer(*sentences: str) -> str:
    """A paragraph each, and how to move about; empty ones left out."""
    about = 'Drag to zoom, double-click to return, click a name to hide its curves.'
    shown = ''.join(f'<p>{escape(text)}</p>' for text in (*sentences, about) if text)
    return f'<footer>{shown}</footer>\n'


def _section(part: Part) -> str:
    if isinstance(part, Table):
        return _table(part)
    return part if isinstance(part, str) else _sheet(part)


def _table(table: Table) -> str:
    """A table that scrolls by itself where the screen is narrower."""
    if not table.rows:
        return ''
    head = ''.join(
        f'<th scope="col"{_number_class(k, table)}>{escape(name)}</th>'
        for k, name in enumerate(table.header)
    )
    rows = ''.join(
        '<tr>'
        + ''.join(f'<td{_number_class(k, table)}>{escape(cell)}</td>' for k, cell in enumerate(row))
        + '</tr>'
        for row in table.rows
    )
    caption = escape(table.caption)
    return (
        f'<section class="card"><h2>{caption}</h2>'
        f'<div class="scroll" tabindex="0" role="region" aria-label="{caption}">'
        f'<table aria-label="{caption}"><thead><tr>{head}</tr></thead>'
        f'<tbody>{rows}</tbody></table></div></section>\n'
    )


def _number_class(k: int, table: Table) -> str:
    return '' if k < table.labels or table.header[k] == 'remark' else ' class="number"'


def _sheet(sheet: Sheet) -> str:
    """What the figure says in words, the places of its plots, its key."""
    said = [text for text in (sheet.caption, *sheet.lines) if text]
    words = ''.join(f'<li>{escape(text)}</li>' for text in said)
    narrow = 1180 if sheet.columns == 1 else 420 if sheet.columns == 2 else 250
    columns = f'repeat(auto-fit,minmax(min({narrow}px,100%),1fr))'
    together = sheet.one_key
    plots = ''.join(
        _panel(place, panel, sheet, own_key=not together)
        for place, panel in zip(place_ids(sheet), sheet.panels, strict=True)
    )
    below = ''.join(f'<span>{MARKS[m].character} {escape(name)}</span>' for m, name in sheet.marks)
    return (
        f'<section class="card{" keyed" if together else ""}" id="{sheet.name}">'
        f'<h2>{escape(sheet.title)}</h2><ul>{words}</ul>'
        f'<figure><div class="panels" style="grid-template-columns:{columns}">{plots}</div>'
        '<noscript>The curves need JavaScript; the tables hold the numbers.</noscript>'
        f'<figcaption>{_key(*sheet.panels) if together else ""}{below}</figcaption>'
        '</figure></section>\n'
    )


def _panel(place: str, panel: Panel, sheet: Sheet, own_key: bool) -> str:
    title = panel.title or sheet.title
    said = f'{title}: {panel.y_label} over {panel.x_label}. {" ".join(sheet.lines)}'.strip()
    return (
        f'<div class="{"keyed" if own_key else ""}">'
        + (f'<h3>{escape(panel.title)}</h3>' if panel.title else '')
        + f'<div class="plot" role="img" aria-label="{escape(said)}" id="{place}"></div>'
        + (f'<figcaption>{_key(panel)}</figcaption>' if own_key else '')
        + '</div>'
    )


def _key(*panels: Panel) -> str:
    return ''.join(
        f'<button type="button" aria-pressed="true" data-label="{escape(entry.label)}">'
        f'{_swatch(entry)} {escape(entry.label)}</button>'
        for entry in key(*panels)
    )


def _swatch(entry: Entry) -> str:
    if entry.stroke:
        return f'<i style="border-top:2px {entry.stroke} {entry.colour}"></i>'
    return f'<span style="color:{entry.colour}">{entry.character}</span>'


def _policy(*scripts: str) -> str:
    """Only these scripts run and nothing is fetched: text from a foreign bag stays text."""
    hashes = (base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts)
    allowed = ' '.join(f"'sha256-{digest}'" for digest in hashes)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )
