"""The page in headless Chromium, where there is one: no error, no request, filters, phones."""

import shutil

import pytest

from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._pages import example_page, gallery_page
from rcac_experiments.reports._cases import case_of
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.reports._rendering import write_page

playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright: pip install it")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine")
# A container's root needs the first; the others keep Chromium from asking for things of its own.
NUMBERS = ("2.2", "2.5", "7.1", "B.2")
FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]


@pytest.fixture(scope="module")
def url(tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "index.html"
    cases = [case_of(verify(load_example(number))) for number in NUMBERS]
    write_page(gallery_page(cases), file)
    return file.as_uri()


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        result = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield result
        result.close()


@pytest.fixture
def opened(browser, url):
    """Open the page at a width, in a scheme, at an anchor; what went wrong fails the test."""
    wrong, pages = [], []

    def open_(width=1280, scheme="light", anchor=""):
        page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
        page.on("console", lambda message: wrong.append(message.text))
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda r: r.url.startswith(("file:", "data:")) or wrong.append(r.url))
        page.goto(url + anchor)
        pages.append(page)
        return page

    yield open_
    assert not wrong
    for page in pages:
        page.close()


@pytest.mark.costly
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [360, 1280])
def test_nothing_is_wider_than_the_window(opened, width, scheme):
    page = opened(width, scheme)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert paper == ("rgb(255, 255, 255)" if scheme == "light" else "rgb(19, 21, 25)")


@pytest.mark.costly
def test_all_that_is_read_stands_in_a_landmark(opened):
    result = opened().evaluate("[...document.body.children].map(part => part.tagName)")
    assert set(result) == {"A", "HEADER", "MAIN", "SCRIPT"} and result.count("A") == 1


def test_the_keyboard_reaches_the_content_the_filters_and_the_words(opened):
    page = opened()
    reached = []

    def tab():
        page.keyboard.press("Tab")
        reached.append(
            page.evaluate("document.activeElement.id || document.activeElement.className "
                          "|| document.activeElement.getAttribute('href') "
                          "|| document.activeElement.tagName")
        )  # fmt: skip

    for _ in range(3 + len(NUMBERS)):
        tab()
    assert reached == ["skip", "theme", *(f"#e{number}" for number in NUMBERS), "SUMMARY"]
    page.keyboard.press("Enter")
    assert page.locator("main > details[open]").count() == 1
    page.keyboard.press("/")
    assert page.evaluate("document.activeElement.id") == "query"
    assert "forward shift" in page.inner_text("main > details")


def test_every_picture_is_there_and_not_empty(opened):
    page = opened()
    page.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    sizes = page.evaluate(
        "[...document.querySelectorAll('figure svg')].map(s => s.getBBox())"
        ".map(box => box.width * box.height)"
    )
    total = sum(len(load_example(number).figures) for number in NUMBERS)
    assert len(sizes) == total > 4 and min(sizes) > 1000


@pytest.mark.costly
def test_filters_work_and_stand_in_the_address(opened):
    page = opened()
    page.keyboard.press("/")
    page.keyboard.type("gain margin nothing")
    assert page.inner_text("#count").startswith("0 of")
    page.keyboard.press("Escape")
    page.select_option("#verdict", "misprint")
    lost = [n for n in NUMBERS for c in load_example(n).claims if c.recorded == "misprint"]
    shown = page.locator("#claims tbody tr:visible")
    assert shown.evaluate_all("rows => rows.map(r => r.dataset.case)") == [f"e{n}" for n in lost]
    assert page.url.endswith("?verdict=misprint")
    remaining = page.locator(".case:not([hidden])")
    assert remaining.count() == len(set(lost)) < len(NUMBERS)
    page.reload()
    assert page.locator("#claims tbody tr:visible").count() == len(lost)


def test_one_click_shows_the_picture_of_an_example(opened):
    page = opened()
    page.click("nav a[href='#e2.2']")
    top = "document.querySelector('[id=\"e2.2\"] figure').getBoundingClientRect().top"
    page.wait_for_function(f"0 < {top} && {top} < 900")  # the page scrolls in its own time


def test_a_link_to_an_example_leads_there(opened):
    page = opened(360, anchor="#e7.1")
    page.wait_for_function(
        "Math.abs(document.getElementById('e7.1').getBoundingClientRect().top) < 60"
    )


def test_the_button_changes_the_theme(opened):
    page = opened()
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.click("#theme")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before


def test_an_injected_script_does_not_run(browser, tmp_path):
    """Whatever a field holds: the policy knows one script by its hash."""
    case = case_of(verify(load_example("B.2")))
    attack = (
        "<script>document.title = 'run'</script><img src=x onerror=\"document.title = 'run'\">"
        '<svg onload="document.title = \'run\'"></svg><a id=link href="javascript:'
        "document.title = 'run'\">x</a><style>body { display: none }</style>"
    )
    fields = ("id", "title", "source", "body", "details", "settings")
    text = example_page(replace(case, **dict.fromkeys(fields, attack)))
    file = tmp_path / "page.html"
    write_page(text, file)
    refused = []
    page = browser.new_page()
    page.on("console", lambda message: refused.append(message.text))
    page.goto(file.as_uri())
    page.evaluate("document.querySelector('main a[id=link]').click()")
    page.wait_for_timeout(300)
    assert page.title() != "run"
    assert page.evaluate("getComputedStyle(document.body).display") == "block"
    assert any("Content Security Policy" in words for words in refused)
    page.click("#theme")  # our own script runs
    assert page.evaluate("document.documentElement.dataset.theme") in ("dark", "light")
    page.close()
