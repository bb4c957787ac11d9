"""How results show themselves in a notebook: a heading and a table of two columns, every text escaped."""

from collections.abc import Mapping
from html import escape


def summary(heading: str, rows: Mapping[str, str]) -> str:
    """HTML of a heading and named values; nothing in them is taken as markup."""
    cells = (f"<tr><th style='text-align:left'>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in rows.items())
    return f"<b>{escape(heading)}</b><table>{''.join(cells)}</table>"
