"""Pictures of runs seen once a period: diagrams, maps, histories, basins. By matplotlib."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.compare.look import GRID, INK, QUIET, UNIT_LINE
from qzs_rig.samples import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HUES = ('#0b62a4', '#c2410c', '#1b9e8a', '#7b6cc4', '#94720b', '#b83280', '#2f7d4f', '#3f4d58')


class Dots(NamedTuple):
    """Points of one kind."""

    label: str
    x: Array
    y: Array
    hue: str


class Wave(NamedTuple):
    """One line."""

    label: str
    x: Array
    y: Array
    hue: str


class Field(NamedTuple):
    """A map of whole numbers over x and y (n_y, n_x), with a colour and a word for each number."""

    x: Array
    y: Array
    which: NDArray[np.int64]
    names: dict[int, tuple[str, str]]


class Scene(NamedTuple):
    """One pair of axes and what is in it, drawn in order."""

    title: str
    x_label: str
    y_label: str
    things: tuple[Dots | Wave | Field, ...]


def drawn(title: str, scenes: Sequence[Scene], columns: int, kind: str) -> bytes:
    """All scenes on one page, `kind` svg or png; the same scenes give the same bytes.

    Raises ImportError where matplotlib is not installed.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    rows = -(-len(scenes) // columns)
    # a fixed salt: the ids inside an SVG are random otherwise
    with rc_context({'font.size': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'qzs_rig'}):
        size = (max(7.6, 4.8 * columns), 3.6 * rows + 0.9)
        figure = Figure(figsize=size, layout='constrained')
        figure.suptitle(title, color=INK, x=0.01, ha='left', fontsize=11.0)
        for place, scene in zip(
            figure.subplots(rows, columns, squeeze=False).ravel(), scenes, strict=False
        ):
            _scene(place, scene)
        page = io.BytesIO()
        stamp: dict[str, Any] = {'Date': None} if kind == 'svg' else {'Software': None}
        figure.savefig(page, format=kind, dpi=150, metadata=stamp)
    return page.getvalue()


def _scene(axes: Axes, scene: Scene) -> None:
    for thing in scene.things:
        DRAW[type(thing)](axes, thing)
    axes.set_title(scene.title, loc='left', color=INK, fontsize=9.0)
    axes.set_xlabel(scene.x_label)
    axes.set_ylabel(scene.y_label)
    if not any(isinstance(thing, Field) for thing in scene.things):
        axes.grid(True, color=GRID, linewidth=0.8)
        axes.set_axisbelow(True)
    axes.tick_params(colors=QUIET)
    for spine in axes.spines.values():
        spine.set_color(UNIT_LINE)
    if axes.get_legend_handles_labels()[1]:
        plain = not any(isinstance(thing, Field) for thing in scene.things)
        axes.legend(frameon=not plain, framealpha=0.9, fontsize=8.0, loc='best')


def _dots(axes: Axes, thing: Dots) -> None:
    # many points weigh too much as vectors
    axes.plot(
        thing.x,
        thing.y,
        linestyle='none',
        marker='.',
        markersize=2.0 if len(thing.x) > 2000 else 5.0,
        markeredgewidth=0.0,
        color=thing.hue,
        rasterized=len(thing.x) > 2000,
    )
    _key(axes, thing.label, thing.hue, 'o')


def _wave(axes: Axes, thing: Wave) -> None:
    axes.plot(thing.x, thing.y, color=thing.hue, label=thing.label, linewidth=1.0)


def _field(axes: Axes, thing: Field) -> None:
    from matplotlib.colors import to_rgb

    picture = np.ones((*thing.which.shape, 3))
    for number, (name, hue) in thing.names.items():
        picture[thing.which == number] = to_rgb(hue)
        _key(axes, name, hue, 's')
    extent = (thing.x[0], thing.x[-1], thing.y[0], thing.y[-1])
    axes.imshow(picture, extent=extent, origin='lower', aspect='auto', interpolation='nearest')


def _key(axes: Axes, label: str, hue: str, marker: str) -> None:
    axes.plot([], [], linestyle='none', marker=marker, markersize=5.0, color=hue, label=label)


DRAW: dict[type, Callable[[Axes, Any], None]] = {Dots: _dots, Wave: _wave, Field: _field}
