"""A page of text, tables and sheets in one file that needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from html import escape

from qzs_rig.report.interactive import drawing, javascript, place_ids
from qzs_rig.report.sheet import MARKS, Entry, Panel, Sheet, key
from qzs_rig.report.table import Table

STYLE = """
:root { color-scheme: light; --ink: #22303c; --quiet: #5d6b77; --line: #dfe4e8; --paper: #f5f7f8; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 28px 20px 40px; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; line-height: 1.3; margin: 0 0 6px; }
h3 { font-size: .95rem; font-weight: 500; margin: 12px 0 0; }
.runs { color: var(--quiet); margin: 4px 0 0; overflow-wrap: anywhere; }
dl { display: flex; flex-wrap: wrap; gap: 12px 36px;
  margin: 18px 0 0; padding: 14px 0; border-block: 1px solid var(--line); }
dt { font-size: .78rem; color: var(--quiet); }
dd { margin: 0; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
nav { display: flex; flex-wrap: wrap; gap: 6px 18px; margin-top: 14px; }
a { color: #0b62a4; text-underline-offset: 3px; }
.card { background: #fff; border: 1px solid var(--line); border-radius: 8px;
  padding: 18px 20px; margin-top: 18px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem;
  font-variant-numeric: tabular-nums; }
th { font-weight: 500; color: var(--quiet); font-size: .82rem; }
th, td { text-align: left; padding: 6px 14px 6px 0; white-space: nowrap;
  border-bottom: 1px solid var(--line); }
tbody tr:last-child td { border-bottom: 0; }
.number { text-align: right; }
.number + td:not(.number), .number + th:not(.number) { padding-left: 12px; }
.card ul { margin: 0 0 8px; padding: 0; list-style: none; color: var(--quiet); font-size: .92rem; }
figure { margin: 0; }
.panels { display: grid; gap: 4px 14px; align-items: start; }
.panels > div { min-width: 0; }
.plot { width: 100%; }
figcaption { display: flex; flex-wrap: wrap; gap: 2px 18px; font-size: .85rem;
  color: var(--quiet); padding-left: 84px; }
figcaption button { font: inherit; color: var(--ink); background: none; border: 0; padding: 2px 0;
  cursor: pointer; text-align: left; overflow-wrap: anywhere; }
figcaption i { display: inline-block; width: 22px; vertical-align: middle; }
figcaption button[aria-pressed=false] { opacity: .4; text-decoration: line-through; }
details summary { cursor: pointer; }
pre { overflow-x: auto; font-size: .82rem; background: var(--paper); padding: 10px;
  border-radius: 6px; }
footer { color: var(--quiet); font-size: .85rem; margin-top: 18px; max-width: 78ch; }
footer p { margin: 0 0 6px; }
@media (max-width: 640px) {
  main { padding: 18px 10px 28px; }
  h1 { font-size: 1.35rem; }
  .card { padding: 14px 10px; border-radius: 6px; }
  dl { gap: 10px 26px; }
  table { font-size: .86rem; }
  th, td { padding-right: 11px; }
  figcaption { padding-left: 0; }
}
@media print {
  @page { margin: 14mm; }
  body { background: #fff; font-size: 11pt; }
  main { max-width: none; padding: 0; }
  .card { border: 0; padding: 0; margin-top: 14px; break-inside: avoid; }
  .scroll { overflow: visible; }
  table { font-size: 8.5pt; }
  th, td { white-space: normal; padding-right: 8px; }
  nav { display: none !important; }
}
"""

BOOT = """
(function () {
  'use strict';
  var drawing = JSON.parse(document.getElementById('drawing').textContent);
  var touch = window.matchMedia('(pointer: coarse)').matches;
  var places = Array.prototype.slice.call(document.querySelectorAll('.plot'));
  window.Bokeh.logger.set_level('warn');
  window.Bokeh.embed.embed_items(drawing.documents, drawing.items).then(function (found) {
    found[0].roots.forEach(function (view) {
      var place = document.getElementById(drawing.items[0].roots[view.model.id]);
      if (!place) { return; }
      place.plot = view.model;
      // A finger on the curves scrolls the page.
      if (touch) {
        place.plot.toolbar.tools.forEach(function (tool) {
          if (tool.type === 'BoxZoomTool') { tool.active = false; }
        });
      }
      place.addEventListener('dblclick', function () { place.plot.reset.emit(); });
      place.dataset.ready = 'yes';
    });
  });
  document.querySelectorAll('button[data-label]').forEach(function (button) {
    button.addEventListener('click', function () {
      var shown = button.getAttribute('aria-pressed') !== 'true';
      button.setAttribute('aria-pressed', String(shown));
      button.closest('.keyed').querySelectorAll('.plot').forEach(function (place) {
        place.plot.renderers.forEach(function (renderer) {
          if (renderer.name === button.dataset.label) { renderer.visible = shown; }
        });
      });
    });
  });
  window.addEventListener('beforeprint', function () {
    places.forEach(function (place) {
      place.style.zoom = Math.min(1, 680 / place.getBoundingClientRect().width);
    });
  });
  window.addEventListener('afterprint', function () {
    places.forEach(function (place) { place.style.zoom = ''; });
  });
}());
"""


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
