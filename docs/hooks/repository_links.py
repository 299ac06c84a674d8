"""Links to files of the repository that are no pages: the site names the file instead."""

import posixpath
import re
from typing import Any

_LINK = re.compile(r"\[([^\]]+)\]\(([^)\s:]+)\)")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """The page's text, with `[words](../file)` as `words (file)` where the file lies outside the pages' folder."""
    folder = posixpath.dirname(page.file.src_uri)

    def named(link: re.Match[str]) -> str:
        words, target = link.groups()
        path = posixpath.normpath(posixpath.join(folder, target))
        if not path.startswith("../"):
            return link[0]
        return words if path[3:] in words else f"{words} (`{path[3:]}`)"

    return _LINK.sub(named, markdown)
