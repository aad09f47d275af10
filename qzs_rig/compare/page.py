"""The shell of every page: style, plotly and the script that draws, in one file. No network."""

from __future__ import annotations

import base64
import hashlib
import html

from qzs_rig.compare.skin import BOOT, STYLE
from qzs_rig.errors import InputError


def page(title: str, body: str) -> str:
    """The page around `body`; raises InputError where plotly is not installed."""
    plotly = _plotly_script()
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_policy(plotly, BOOT)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{html.escape(title)}</title>
<style>{STYLE}</style>
</head>
<body>
<main>
{body}</main>
<script>{plotly}</script>
<script>{BOOT}</script>
</body>
</html>
"""


def _plotly_script() -> str:
    try:
        from plotly.offline import get_plotlyjs  # type: ignore[import-untyped, unused-ignore]
    except ImportError as error:
        raise InputError(
            'a report needs the package plotly; install it with: pip install plotly'
        ) from error
    # Spelt so that no string in it ends the script element, and with the line ends a browser
    # hashes.
    return str(get_plotlyjs()).replace('\r\n', '\n').replace('</script', r'<\/script')


def _policy(*scripts: str) -> str:
    """Only these scripts run and nothing is fetched: text from a foreign bag stays text."""
    hashes = (base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts)
    allowed = ' '.join(f"'sha256-{digest}'" for digest in hashes)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )
