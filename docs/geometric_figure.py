"""The drawing in geometric.md, to scale for Table 1 (`python docs/geometric_figure.py`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

SCALE = 620.0  # drawing units a metre
L0, SPAN, L1 = 0.06, 0.3, 0.52
R = L0 + SPAN
INK, SPRING, LEAF, FAINT = '#222', '#1f6fb4', '#c0561a', '#999'


def main() -> None:
    """Side view with the plate lowered, and plan."""
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1080 560" font-family="sans-serif" '
        'font-size="16">',
        '<rect width="1080" height="560" fill="white"/>',
        _side(270, 250),
        _plan(810, 270),
        '</svg>',
    ]
    path = Path(__file__).with_name('geometric.svg')
    path.write_text('\n'.join(parts) + '\n', encoding='utf-8')
    print(path)


def _side(x: float, y: float) -> str:
    """Seen along y: the arms on +-x with the plate at x_down below the working point."""
    down, r, l0 = 0.13 * SCALE, R * SCALE, L0 * SCALE
    parts = [_text(x, 30, 'side view, plate lowered by x', bold=True)]
    parts += [_line(x - r - 30, y, x + r + 30, y, FAINT, dash='6 5')]
    parts += [_text(x - r - 12, y - 16, 'working point', 'start', FAINT)]
    for side in (-1, 1):
        anchor, end = (x + side * r, y), (x + side * l0, y + down)
        parts.append(_coil(anchor, end, SPRING))
        parts.append(_leaf(anchor, end))
        parts.append(_line(x + side * r, y, x + side * r, y + 190, INK, 3))
        parts.append(_dot(*anchor))
        parts.append(_dot(*end))
    parts.append(_line(x - r - 30, y + 190, x + r + 30, y + 190, INK, 6))
    parts.append(_text(x + r - 40, y + 215, 'base plate'))
    parts.append(_line(x - l0 - 8, y + down, x + l0 + 8, y + down, INK, 8))
    parts.append(_line(x, y, x, y + down, '#2a8a3a', 4))
    parts.append(_dot(x, y, '#2a8a3a'))
    parts.append(_text(x + 8, y + 28, 'k1', 'start', '#2a8a3a'))
    # centre of mass on a mast, drawn aside of the spring
    parts.append(_line(x - 20, y + down, x - 20, y - 60, FAINT, 2))
    parts.append(_dot(x - 20, y - 60, INK, 8))
    parts.append(_text(x - 34, y - 66, 'm, cm_height above the plate', 'end'))
    parts.append(_line(x + l0 + 14, y + down, x + r, y + down, FAINT, dash='3 4'))
    parts.append(_text(x + 36, y - 16, 'suspension k2/4, length l', 'start', SPRING))
    parts.append(_text(x + 0.20 * r, y + down + 44, 'leaf k3/4 turns against', 'start', LEAF))
    parts.append(_text(x + 0.20 * r, y + down + 62, 'the inclination φ', 'start', LEAF))
    parts.append(_text(x + l0 + 118, y + down - 8, 'φ', 'middle', LEAF))
    bottom = y + 245
    parts.append(_measure(x, x + l0, bottom, 'L0'))
    parts.append(_measure(x + l0, x + r, bottom, 'span h (a L20 on the axis)'))
    parts.append(_rise(x + r + 22, y, y + down, 'x'))
    return '\n'.join(parts)


def _plan(x: float, y: float) -> str:
    """Seen from above: four arms, a quarter turn apart."""
    parts = [_text(x, 30, 'plan, at the working point', bold=True)]
    r, l0 = 0.62 * R * SCALE, 0.62 * L0 * SCALE
    for quarter in range(4):
        c, s = np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)
        anchor, end = (x + r * c, y - r * s), (x + l0 * c, y - l0 * s)
        parts.append(_coil(anchor, end, SPRING))
        parts.append(_leaf(anchor, end))
        parts.append(_dot(*anchor))
    parts.append(
        f'<circle cx="{x}" cy="{y}" r="{l0:.1f}" fill="#ddd" stroke="{INK}" stroke-width="3"/>'
    )
    parts.append(f'<circle cx="{x}" cy="{y}" r="{r:.1f}" fill="none" stroke="{FAINT}" '
                 'stroke-dasharray="6 5"/>')  # fmt: skip
    parts.append(_arrow(x, y, x + 70, y - 0, 'x'))
    parts.append(_arrow(x, y, x, y - 62, 'y'))
    notes = (
        ('base anchors at radius L0 + a L20', INK),
        ('suspension springs: natural length L20, compressed to a L20 here', SPRING),
        ('leaf springs: preloaded, they carry k3 L1', LEAF),
        ('central spring: under the plate, k1, natural length L10', '#2a8a3a'),
    )
    for n, (note, colour) in enumerate(notes):
        parts.append(_text(x - 230, y + r + 50 + 24 * n, note, 'start', colour))
    return '\n'.join(parts)


def _line(x1, y1, x2, y2, colour=INK, width=2.0, dash='') -> str:
    dashes = f' stroke-dasharray="{dash}"' if dash else ''
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
        f'stroke-width="{width}"{dashes}/>'
    )


def _text(x, y, words, anchor='middle', colour=INK, bold=False) -> str:
    weight = ' font-weight="bold"' if bold else ''
    place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f'<text {place} fill="{colour}"{weight}>{words}</text>'


def _dot(x, y, colour=INK, r=5.0) -> str:
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r}" fill="{colour}"/>'


def _coil(start, end, colour, turns=9, width=8.0) -> str:
    a, b = np.array(start), np.array(end)
    along = (b - a) / np.linalg.norm(b - a)
    across = np.array([-along[1], along[0]])
    shares = np.linspace(0.12, 0.88, 2 * turns)
    zigzag = [a + t * (b - a) + width * (-1) ** n * across for n, t in enumerate(shares)]
    points = [a, a + 0.1 * (b - a), *zigzag, a + 0.9 * (b - a), b]
    path = ' '.join(f'{x:.1f},{y:.1f}' for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>'


def _leaf(start, end) -> str:
    a, b = np.array(start), np.array(end)
    along = (b - a) / np.linalg.norm(b - a)
    shift = 15.0 * np.array([-along[1], along[0]]) * (1 if along[0] < 0 or along[1] > 0.9 else -1)
    shift = shift if shift[1] >= 0 else -shift
    (x1, y1), (x2, y2) = a + shift, b + shift
    return _line(x1, y1, x2, y2, LEAF, 4)


def _measure(x1, x2, y, words) -> str:
    ends = ''.join(_line(x, y - 7, x, y + 7, INK, 1.5) for x in (x1, x2))
    return _line(x1, y, x2, y, INK, 1.5) + ends + _text((x1 + x2) / 2, y + 26, words)


def _rise(x, y1, y2, words) -> str:
    ends = ''.join(_line(x - 7, y, x + 7, y, INK, 1.5) for y in (y1, y2))
    return _line(x, y1, x, y2, INK, 1.5) + ends + _text(x + 14, (y1 + y2) / 2 + 5, words)


def _arrow(x1, y1, x2, y2, words) -> str:
    a, b = np.array([x1, y1]), np.array([x2, y2])
    along = (b - a) / np.linalg.norm(b - a)
    across = np.array([-along[1], along[0]])
    tip = ' '.join(f'{p[0]:.1f},{p[1]:.1f}' for p in (b, b - 12 * along + 5 * across,
                                                      b - 12 * along - 5 * across))  # fmt: skip
    label = b + 14 * along + np.array([0, 5]) + (0 if along[0] > 0.5 else np.array([-24, 14]))
    return (
        _line(x1, y1, x2, y2, INK, 2)
        + f'<polygon points="{tip}" fill="{INK}"/>'
        + _text(label[0], label[1] + (18 if along[0] > 0.5 else 0), words)
    )


if __name__ == '__main__':
    main()
