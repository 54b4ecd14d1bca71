"""Run examples of the built pages and a lecture in Chromium, as a reader does.

``python -m docs.browser.check docs/_build`` follows ``python -m docs.browser docs/_build``. It
fails where an answer differs from the one that the page prints, where a formula is not set, where
an error, Stop or missing Python is not said, and where a page asks another server. A lecture is
drawn; ``--lecture all`` runs each. Without a browser it ends with status 69.
"""

import argparse
import random
import re
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from doctest import ELLIPSIS, NORMALIZE_WHITESPACE, DocTestParser, OutputChecker
from pathlib import Path
from typing import Any

import compensator_theory
from docs.browse import NOT_CHECKED, NoBrowserError, chromium, new_page, served
from docs.browser.examples import examples_of_page
from docs.browser.pages import ROOT, exact_lectures

GUIDE, REFERENCE = "constructions", "reference/api/compensator_theory.place_poles"
PATIENCE = 120_000  # ms; a busy machine takes its time
IDLE = "form => !form.querySelector('button[type=submit]').disabled"
ANSWERS = """form => [...form.querySelectorAll('.answers .source')].map(
  source => [source.textContent, source.nextElementSibling.matches('pre')
    ? source.nextElementSibling.textContent : null])"""
FAILURE = "[data-mime-type$='jupyter.error'], [data-mime-type$='jupyter.stderr']"
FINISHED = f"""() => document.querySelector("{FAILURE}")
  || [...document.querySelectorAll('.jp-CodeCell .jp-InputPrompt')].every(
    prompt => /[0-9]/.test(prompt.innerText))"""


def main() -> int:
    """Check a built site; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("site", type=Path)
    parser.add_argument("--lecture", help="its name, or all; drawn by default")
    parser.add_argument("--seed", type=int, help="of the draw")
    options = parser.parse_args()
    names = [path.stem for path in exact_lectures()]
    if options.lecture not in {None, "all", *names}:
        parser.error(f"the exact lectures are {', '.join(names)}")
    drawn = (
        names
        if options.lecture == "all"
        else [options.lecture or random.Random(options.seed).choice(names)]
    )
    wrong: list[str] = []
    try:
        with chromium() as browser, served(options.site) as site:
            wrong += without_python(browser, site)
            wrong += guide(browser, site)
            wrong += reference(browser, site)
            for name in drawn:
                wrong += lecture(browser, site, name)
    except NoBrowserError as error:
        print(f"NOT CHECKED: Python in the browser was not run; {error}")
        return NOT_CHECKED
    print("\n".join(wrong) or "Python in the browser: a guide page, a reference page, a lecture")
    return 1 if wrong else 0


def without_python(browser: Any, site: str) -> Iterator[str]:
    """Whether a page says how to add Python, where it was built without."""
    page = new_page(browser, site)
    page.set_default_timeout(PATIENCE)
    page.route("**/lite/**", lambda route: route.fulfill(status=404))
    for name, place in (
        (GUIDE, ".try-it-offer"),
        (f"notebooks/{exact_lectures()[0].stem}", ".try-lecture"),
    ):
        page.goto(f"{site}/{name}.html")
        page.locator(f"{place} :is(button, a)").first.click()
        region = page.locator(f"{place} [role=status]").first
        region.filter(has_text="python -m docs.browser").wait_for()
        if page.locator("form.try").count():
            yield f"{name} opens an example without Python"
    page.close()


def guide(browser: Any, site: str) -> Iterator[str]:
    """What is wrong with the answers of a page, an error, and Stop."""
    with watched(browser, site) as (page, wrong):
        page.goto(f"{site}/{GUIDE}.html")
        block = examples_of_page((ROOT / "docs" / f"{GUIDE}.md").read_text("utf-8"))[0]
        form, seconds = run_first(page)
        print(f"{GUIDE}: first answer after {seconds:.1f} s")
        page.wait_for_function(IDLE, arg=form.element_handle())
        yield from differences(block, form.evaluate(ANSWERS))
        yield from (f"not set: {text}" for text in page.locator(".not-set").all_inner_texts())
        if not page.locator("form.try math").count():
            yield f"{GUIDE} shows no formula"

        form.locator("textarea").fill(
            "from compensator_theory import transfer_function\ntransfer_function('1/(')"
        )
        began = time.monotonic()
        form.locator("button[type=submit]").click()
        error = form.locator(".error")
        error.wait_for()
        print(f"{GUIDE}: a next answer after {time.monotonic() - began:.2f} s")
        if not re.fullmatch(r"InputError: .* \(line 2\)", error.inner_text()):
            yield f"the error reads {error.inner_text()!r}"

        form.locator("textarea").fill("while True: pass")
        form.locator("button[type=submit]").click()
        form.get_by_text("computing").wait_for()
        form.get_by_text("Stop").click()
        form.locator(".error", has_text="stopped").wait_for()
        yield from wrong


def reference(browser: Any, site: str) -> Iterator[str]:
    """What is wrong with the answers of a docstring's example."""
    with watched(browser, site) as (page, wrong):
        page.goto(f"{site}/{REFERENCE}.html")
        form, _ = run_first(page)
        page.wait_for_function(IDLE, arg=form.element_handle())
        text = getattr(compensator_theory, REFERENCE.rpartition(".")[2]).__doc__
        yield from differences(text, form.evaluate(ANSWERS))
        yield from wrong


def lecture(browser: Any, site: str, name: str) -> Iterator[str]:
    """What is wrong with a lecture, reached from its page and run whole."""
    with watched(browser, site) as (page, wrong):
        page.goto(f"{site}/notebooks/{name}.html")
        began = time.monotonic()
        page.click(".try-lecture a")
        page.locator(".jp-CodeCell").first.wait_for()
        shown = time.monotonic() - began
        for menu, command in (
            ("Edit", "Clear Outputs of All Cells"),
            ("Run", "Run All Cells"),
        ):
            page.get_by_role("menuitem", name=menu, exact=True).click()
            page.get_by_text(command, exact=True).click()
        page.wait_for_function(FINISHED, timeout=2 * PATIENCE)
        print(f"{name}: shown after {shown:.1f} s, run after {time.monotonic() - began:.1f} s")
        for text in page.locator(FAILURE).all():
            yield f"{name}: {text.inner_text()}"
        yield from wrong


@contextmanager
def watched(browser: Any, site: str) -> Iterator[tuple[Any, list[str]]]:
    """A page, and what its console and its requests say against it."""
    page = new_page(browser, site)
    page.set_default_timeout(PATIENCE)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(f"{page.url}: {error}"))
    page.on("request", lambda request: wrong.extend(_elsewhere(request.url, site)))
    yield page, wrong
    page.close()


def _elsewhere(address: str, site: str) -> Iterator[str]:
    """An address that is not the site's; what a page makes of its own has none."""
    if not address.startswith((site, "data:", "blob:")):
        yield f"{address} is asked"


def run_first(page: Any) -> tuple[Any, float]:
    """Try the first example of a page; its form, and the seconds to the first answer."""
    began = time.monotonic()
    page.locator(".try-it-offer button").first.click()
    form = page.locator("form.try")
    form.locator(".answers > *").first.wait_for()
    return form, time.monotonic() - began


def differences(example: str, answers: Sequence[tuple[str, str | None]]) -> Iterator[str]:
    """Answers that are not those of a session; formulas are left out."""
    printed = [one for one in DocTestParser().get_examples(example) if one.want]
    if len(printed) != len(answers):
        yield f"{len(answers)} answers instead of {len(printed)}"
    same = OutputChecker().check_output
    for one, (source, text) in zip(printed, answers, strict=False):
        if text is not None and not same(one.want, f"{text}\n", ELLIPSIS | NORMALIZE_WHITESPACE):
            yield f"{source} answers {text!r} instead of {one.want!r}"


if __name__ == "__main__":
    sys.exit(main())
