"""The sections of a report as HTML; every text that comes from outside is escaped here."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape

from qzs_rig.compare.look import ARROWS, event_mark
from qzs_rig.compare.panels import Labelled, Shown, shown
from qzs_rig.compare.plot import figure
from qzs_rig.estimation.estimate import EVENT_KINDS
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.names import direction_name, dof_name, event_name
from qzs_rig.report.table import Table, number


def header(
    title: str, estimates: Labelled, facts: Sequence[tuple[str, str]], dofs: Sequence[str]
) -> str:
    """Title, runs, facts of the run, and links to the figures when there are several."""
    runs = ' · '.join(escape(label) for label, _ in estimates)
    items = ''.join(
        f'<div><dt>{escape(name)}</dt><dd>{escape(text)}</dd></div>' for name, text in facts
    )
    links = ''.join(f'<a href="#figure-{k}">{_heading(dof)}</a>' for k, dof in enumerate(dofs))
    parts = [
        f'<h1>{escape(title)}</h1>',
        f'<p class="runs">{runs}</p>' if runs else '',
        f'<dl>{items}</dl>' if facts else '',
        f'<nav aria-label="figures">{links}</nav>' if len(dofs) > 1 else '',
    ]
    return f'<header>{"".join(parts)}</header>\n'


def table_section(table: Table) -> str:
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


def figure_section(k: int, dof: str, estimates: Labelled, theory: Sequence[Prediction]) -> str:
    """Figure number `k`: what it says in words, the place to draw it, and its data."""
    drawing = figure(dof, estimates, theory)
    curves = shown(dof, estimates)
    words = [_sentence(item, len(estimates) > 1) for item in curves]
    size = 'tall' if 'yaxis3' in drawing['layout'] else 'low'
    alternative = f'Transmissibility of {dof_name(dof)} over frequency. {" ".join(words)}'
    # "<" would let a label end the script element; JSON may spell it as an escape.
    data = json.dumps(drawing, allow_nan=False).replace('<', '\\u003c')
    lines = ''.join(f'<li>{escape(sentence)}</li>' for sentence in words)
    return (
        f'<section class="card" id="figure-{k}"><h2>{_heading(dof)}</h2><ul>{lines}</ul>'
        f'<figure><div class="plot {size}" role="img" aria-label="{escape(alternative)}" '
        f'data-figure="data-{k}"></div>'
        f'<script type="application/json" id="data-{k}">{data}</script>'
        '<noscript>The curves need JavaScript; the tables hold the numbers.</noscript>'
        f'<figcaption>{_key(curves)}</figcaption></figure></section>\n'
    )


def quality_section(estimates: Labelled) -> str:
    """What each estimator said about its input, folded away."""
    parts = [
        f'<h3>{escape(label)}</h3>'
        f'<pre>{escape(json.dumps(estimate.quality, indent=2, default=str))}</pre>'
        for label, estimate in estimates
        if estimate.quality
    ]
    if not parts:
        return ''
    return (
        '<section class="card"><details><summary>What the estimator saw</summary>'
        f'{"".join(parts)}</details></section>\n'
    )


def reading_section(estimates: Labelled, theory: Sequence[Prediction]) -> str:
    """The conventions, and which estimator each curve is from."""
    used = sorted({(curve.estimator, curve.quantity) for _, e in estimates for curve in e.curves})
    sources = '; '.join(f'{escape(name)} ({escape(quantity)})' for name, quantity in used)
    lines = [
        'T is the amplitude of the top plate over that of the base plate; the platform isolates '
        'where T &lt; 1. The phase is that of the top against the base, negative when it lags. '
        'THD is the root sum square of the top&#39;s harmonics over its fundamental.',
        f'Estimated by: {sources}.' if sources else '',
        'Theory: solid where the motion is stable, dashed where it is not, an arrow where a sweep '
        'cannot go on and jumps up or down. A measured point is on the stable branch nearest in T, '
        'on none farther than a factor of 2; σ is the stated uncertainty of the point.'
        if theory
        else '',
        'Drag to zoom, double-click to return, click a name to hide its curves.',
    ]
    return '<footer>' + ''.join(f'<p>{line}</p>' for line in lines if line) + '</footer>\n'


def _sentence(item: Shown, several: bool) -> str:
    """The events of one curve in words."""
    order = {kind: k for k, kind in enumerate(EVENT_KINDS)}
    events = sorted(item.events, key=lambda event: order.get(event.kind, len(order)))
    said = []
    for event in events:
        height = f' (T = {number(event.magnitude)})' if event.kind == 'peak' else ''
        said.append(f'{event_name(event.kind)} at {number(event.frequency_hz)} Hz{height}')
    direction = direction_name(item.curve.direction)
    who = f'{item.label}, {direction}' if several else direction[:1].upper() + direction[1:]
    return f'{who}: {", ".join(said) or "no onset, peak or jump found"}.'


def _key(curves: Sequence[Shown]) -> str:
    """The marks used in this figure."""
    kinds = dict.fromkeys(event.kind for item in curves for event in item.events)
    directions = dict.fromkeys(item.curve.direction for item in curves)
    marks = [
        *(f'{ARROWS[d].character} {d}' for d in directions if d in ARROWS),
        *(f'{event_mark(kind).character} {escape(event_name(kind))}' for kind in kinds),
    ]
    return ' '.join(f'<span>{mark}</span>' for mark in marks)


def _heading(dof: str) -> str:
    name = dof_name(dof)
    return escape(name[:1].upper() + name[1:])


def _number_class(k: int, table: Table) -> str:
    return '' if k < table.labels or table.header[k] == 'remark' else ' class="number"'
