"""The report's style sheet and the script that draws its figures."""

from __future__ import annotations

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
