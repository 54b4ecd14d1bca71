"""Look at the built docs in Chromium: search, console, width, light and dark.

``python docs/browse.py docs/_build`` fails where a search does not find its page first, where a
page scrolls sideways at 360 or 1280 pixels, or where the console has an error. Without a browser
it says that nothing was checked, and ends with status 69.
"""

import argparse
import re
import shutil
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

# What is searched for, and the pages of which one is to come first.
FOLDER = Path(__file__).resolve().parents[1] / "tests" / "docs"
SEARCHES = [FOLDER / "searches.toml", FOLDER / "searches_kept_back.toml"]
TYPED = "saturation"  # the one of them that is searched as a reader does; the others ask the index
FIRST = """question => {
  history.replaceState(null, "", `search.html?q=${encodeURIComponent(question)}`);
  const found = Search._performSearch(...Search._parseQuery(question));
  return found.reverse().slice(0, 5).map(result => result[0]);
}"""
LOOKED_AT = (
    "index",
    "install",
    "explorer",
    "guide/my-plant",
    "guide/log-to-verdict",
    "gallery/index",
    "command-line",
    "experiment-files",
    "constructions",
    "notebooks/what_rcac_fits",
    "reference/index",
    "reference/controllers",
    "reference/api/rcac_numeric.ControllerSettings",
    "reference/api/compensator_theory.strategies",
    "reference/equations",
    "citations",
    "changelog",
)
WIDTHS = (360, 1280)
NOT_CHECKED = 69


def main() -> int:
    """Check a built site; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("site", type=Path)
    parser.add_argument("--pictures", type=Path, help="a folder for pictures of each page")
    options = parser.parse_args()
    try:
        with chromium() as browser, served(options.site) as site:
            questions = {
                question: pages
                for path in SEARCHES
                for question, pages in tomllib.loads(path.read_text()).items()
            }
            wrong = [*searches(browser, site, questions), *views(browser, site, options.pictures)]
    except NoBrowserError as error:
        print(f"NOT CHECKED: the docs were not opened; {error}")
        return NOT_CHECKED
    print(
        "\n".join(wrong) or f"docs in Chromium: {len(questions)} searches, {len(LOOKED_AT)} pages"
    )
    return 1 if wrong else 0


class NoBrowserError(Exception):
    """Chromium cannot be driven on this machine, for the reason that it says."""


@contextmanager
def chromium() -> Iterator[Any]:
    """Chromium without a window.

    Raises
    ------
    NoBrowserError
        Chromium or Playwright are not installed, or Chromium does not start.
    """
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        raise NoBrowserError("that needs Chromium")
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        raise NoBrowserError("that needs Playwright") from None
    with sync_playwright() as driver:
        try:
            browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        except Error as error:
            raise NoBrowserError(f"Chromium does not start: {error}") from error
        yield browser
        browser.close()


@contextmanager
def served(site: Path) -> Iterator[str]:
    """The site's address on this machine; a search reads pages, and may not read files."""
    handler = partial(Quiet, directory=str(site))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class Quiet(SimpleHTTPRequestHandler):
    """A server that keeps its requests for itself."""

    def log_message(self, *args: Any) -> None:
        """Say nothing."""


def new_page(browser: Any, site: str, **options: Any) -> Any:
    """A page that asks nobody but the site; its console says what else was asked for."""
    page = browser.new_page(**options)
    page.route(
        lambda address: not address.startswith(site), lambda route: route.abort("blockedbyclient")
    )
    return page


def searches(browser: Any, site: str, expected: dict[str, list[str]]) -> Iterator[str]:
    """What is not found first."""
    page = new_page(browser, site)
    page.goto(f"{site}/search.html?q={TYPED}")
    page.wait_for_function(  # results come one by one, and then this
        "document.querySelector('.search-summary')?.textContent.match(/\\d/)", timeout=60_000
    )
    links = page.eval_on_selector_all(
        "#search-results ul.search > li > a", "found => found.slice(0, 5).map(a => a.href)"
    )
    shown = [re.sub(r"^https?://[^/]+/|\.html|[?#].*", "", link) for link in links]
    for question, pages in expected.items():
        titles = shown if question == TYPED else page.evaluate(FIRST, question)
        if not titles or titles[0] not in pages:
            yield f'search for "{question}": {pages[0]} is not first but {", ".join(titles)}'


def views(browser: Any, site: str, pictures: Path | None) -> Iterator[str]:
    """Pages that scroll sideways, and what their consoles say."""
    for width in WIDTHS:
        for scheme in ("light", "dark"):
            view = {"width": width, "height": 900}
            page = new_page(browser, site, viewport=view, color_scheme=scheme)
            messages: list[str] = []
            page.on("pageerror", lambda error, errors=messages: errors.append(str(error)))
            page.on("console", lambda m, errors=messages: errors.extend(_error(m)))
            for name in LOOKED_AT:
                page.goto(f"{site}/{name}.html", wait_until="load")
                wide = page.evaluate("document.documentElement.scrollWidth")
                if wide > width:
                    yield f"{name} is {wide} pixels wide at {width}, {scheme}"
                yield from (f"{name}: {words}" for words in messages)
                messages.clear()
                if pictures:
                    file = f"{name.replace('/', '-')}-{width}-{scheme}.png"
                    pictures.mkdir(exist_ok=True)
                    page.screenshot(path=pictures / file)
            page.close()


def _error(message: Any) -> Iterator[str]:
    """A line of the console, if it is an error; sites need no icon."""
    if message.type == "error" and not message.location["url"].endswith("favicon.ico"):
        yield f"{message.text} {message.location['url']}"


if __name__ == "__main__":
    sys.exit(main())
