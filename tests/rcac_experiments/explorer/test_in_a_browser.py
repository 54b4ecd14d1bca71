"""The explorer in headless Chromium: the bits of core and `simulate`, drags, keys, widths."""

import random
import re
import shutil
import tomllib
from fractions import Fraction
from importlib import resources

import mpmath
import numpy as np
import pytest

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_experiments import explore
from rcac_experiments.explorer._case import SCENES, case_of
from rcac_experiments.explorer._page import explorer_page
from rcac_experiments.files._builder import build
from rcac_numeric import ClosedLoop, stability_margins
from rcac_numeric.arrays._validation import rounded
from rcac_numeric.controllers._bounds import ellipsoid_radii
from rcac_numeric.export._tables import core_tables
from rcac_numeric.reports._rendering import write_page
from tests.support.core_builds import Core, compiler
from tests.support.explorer_cases import own

playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright: pip install it")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine"),
]
FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
ORDERS = (1, 2, 3, 4)
SLIDERS = (
    "R_theta",
    "n_c",
    "gain",
    "delay",
    "d_zu",
    "noise",
    "amplitude",
    "bound",
    "lambda",
    "k_w",
    "steps",
)
LOOP = """() => {
  const { found, outcome, dials } = explorer, list = values => Array.from(values);
  return { z: list(found.z), u: list(found.u), y: list(found.y), theta: list(found.theta),
    done: found.done, lost: found.lost, kind: outcome.kind, num: found.plan.num,
    den: found.plan.den, dials, sentence: document.getElementById("sentence").textContent,
    toml: document.getElementById("toml").value, margins: explorer.lost ? null : explorer.margins,
    shares: found.shares && list(found.shares), projected: found.projected && list(found.projected),
    ofSet: document.getElementById("of-set").textContent, predicted: explorer.predicted,
    besides: document.getElementById("besides").textContent,
    wrong: document.getElementById("wrong").textContent };
}"""
MOVE = """([key, part]) => {
  const slider = document.getElementById(key), { min, max } = slider;
  slider.value = Number(min) + part * (max - min);
  slider.dispatchEvent(new Event("input"));
}"""
PURE = ("rationals", "formulas", "roots")
DRAWN = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def url(tmp_path_factory):
    file = tmp_path_factory.mktemp("explorer") / "index.html"
    write_page(explorer_page(case_of(own(), "own.toml"), ORDERS), file)
    return file.as_uri()


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        result = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield result
        result.close()


@pytest.fixture
def opened(browser, url):
    """Open the page; an error, a word in the console or a request fails the test."""
    wrong, pages = [], []

    def open_(width=1280, scheme="light", touch=False):
        page = browser.new_page(
            viewport={"width": width, "height": 900}, color_scheme=scheme, has_touch=touch
        )
        page.on("console", lambda message: wrong.append(message.text))
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda r: r.url.startswith(("file:", "data:")) or wrong.append(r.url))
        page.goto(url)
        page.wait_for_selector("[data-ready]")
        page.evaluate(DRAWN)
        pages.append(page)
        return page

    yield open_
    assert not wrong
    for page in pages:
        page.close()


@pytest.fixture(scope="module")
def scripts(browser):
    """A page without anything, to which the modules without a document are known."""
    page = browser.new_page()
    folder = resources.files("rcac_experiments.explorer").joinpath("scripts")
    text = "".join(folder.joinpath(f"{name}.js").read_text("utf-8") for name in PURE)
    text = re.sub(r"^(import .*;\n|export )", "", text, flags=re.MULTILINE)
    names = (
        "rational, rounded, exactly, written, transferFunction, rootsOf, distances, backwardError"
    )
    page.add_script_tag(content=f"globalThis.known = (() => {{{text}; return {{ {names} }}; }})();")
    yield page
    page.close()


def settle(page):
    page.evaluate(DRAWN)
    evaluation = page.evaluate(LOOP)
    evaluation["theta"] = np.array(evaluation["theta"]).reshape(-1, 2 * evaluation["dials"]["n_c"])
    return evaluation


def same_bits(a, b):
    return np.asarray(a, dtype=np.float64).tobytes() == np.asarray(b, np.float64).tobytes()


def as_simulated(state):
    """Its settings, read and run by Python: every signal and theta have the bits of the page."""
    specification = build(tomllib.loads(state["toml"]), "page.toml").main_run
    run = specification.execute().first.run
    assert (run.steps, run.outcome != "completed") == (state["done"], state["lost"])
    steps = run.steps
    for name in ("z", "u", "y"):
        assert same_bits(state[name][:steps], getattr(run, name)[:steps, 0])
    assert same_bits(state["theta"][:steps], run.theta[:steps])
    assert same_bits(state["theta"][-1], run.theta_final)
    return specification


def moved_at_random(page, draw):
    for key in draw.sample(SLIDERS, 3):
        if page.is_enabled(f"#{key}"):
            page.evaluate(MOVE, [key, draw.random()])
    if draw.random() < 0.5:
        page.select_option("#signal", draw.choice(["step", "wave", "command", "none"]))
    settle(page)  # a plant that moved may have no set, which the page says a moment later
    if page.is_enabled("#kept"):
        page.set_checked("#kept", draw.random() < 0.5)


@pytest.mark.costly
def test_every_scene_and_the_case_are_those_of_simulate_bit_for_bit(opened, monkeypatch):
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")
    page = opened()
    assert page.locator("#scenes button").count() == 1 + len(SCENES)
    for number in range(1 + len(SCENES)):
        page.locator("#scenes button").nth(number).click()
        specification = as_simulated(settle(page))
        assert specification.execute().as_expected


@pytest.mark.costly
@pytest.mark.parametrize("name", ["A wrong sign", "Poles that were not", "Follow a command"])
def test_a_run_kept_in_the_set_is_that_of_simulate_and_of_the_core_bit_for_bit(
    opened, monkeypatch, name
):
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")
    page = opened()
    page.get_by_role("button", name=name).click()
    free = settle(page)
    radius = np.array(free["shares"])
    assert free["projected"] is None and radius[0] == 0 and radius.max() > 1
    assert f"leaves it at step {np.argmax(radius > 1)}." in free["ofSet"]
    page.check("#kept")
    state = settle(page)
    run = as_simulated(state).execute().first.run
    assert run.outcome == "completed" and run.bounded > 0
    assert sum(state["projected"]) in (run.bounded, run.bounded - 1)  # perhaps in the last update
    shares = np.array(state["shares"])
    assert shares.max() <= 1 and run.settings.bounds.contains(state["theta"])
    error = 1 - ellipsoid_radii(run.settings.bounds)[0]
    np.testing.assert_allclose(shares[: run.steps], run.radius, rtol=0, atol=error)
    assert f"first at step {state['projected'].index(1)}." in state["ofSet"]
    if compiler() is None:
        return
    core = Core(core_tables(run.settings))
    for k in range(state["done"]):
        assert same_bits(core.radius, shares[k]) and same_bits(core.theta, state["theta"][k])
        core.step([state["y"][k]], [state["z"][k]])


@pytest.mark.costly
def test_the_switch_is_only_where_the_set_belongs_to_plant_order_and_signs(opened):
    page = opened()
    page.get_by_role("button", name="An unstable plant").click()
    settled = settle(page)
    assert page.is_disabled("#kept") and "does not stabilise" in settled["ofSet"]
    page.get_by_role("button", name="A wrong sign").click()
    settle(page)
    page.check("#kept")
    before = settle(page)
    page.evaluate(MOVE, ["n_c", 0.5])
    other = settle(page)
    assert page.is_disabled("#kept") and other["shares"] is None
    assert "bounds" not in other["toml"] and "theta_0" not in other["toml"]
    for dials in ('G = "1/(q - 0.5)"', "delay = 1", 'signal = "command"'):
        page.get_by_role("button", name="A wrong sign").click()
        settle(page)
        page.evaluate(f"explorer.dials.{dials}, explorer.change()")
        moved = settle(page)
        assert moved["shares"] is None and page.is_disabled("#kept")
        assert "theta_0" in moved["toml"]
    page.get_by_role("button", name="A wrong sign").click()
    settle(page)
    page.check("#kept")
    assert settle(page)["theta"].tobytes() == before["theta"].tobytes()


@pytest.mark.slow
def test_twenty_settings_come_back_as_files_with_the_same_run(opened, monkeypatch):
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")
    page, draw, kinds = opened(), random.Random(33), set()
    for _ in range(20):
        page.locator("#scenes button").nth(draw.randrange(1 + len(SCENES))).click()
        moved_at_random(page, draw)
        settled = settle(page)
        assert not settled["wrong"]
        as_simulated(settled)
        kinds.add(settled["kind"])
    assert len(kinds) >= 3  # some are lost, some stable, some reach the rings


@pytest.mark.costly
def test_what_saturates_has_the_bits_of_simulate_and_says_so(opened, monkeypatch):
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")
    page, shares = opened(), []
    for part in (0.2, 0.3, 0.4):
        page.get_by_role("button", name="Follow a command").click()
        page.evaluate(MOVE, ["bound", part])
        settled = settle(page)
        run = as_simulated(settled).execute().first.run
        learnt = run.u[run.settings.k_w :]
        at_limit = np.abs(learnt) > float(settled["dials"]["bound"])
        shares.append(at_limit.mean())
        message = re.search(r"at its limit in (\d+) %", settled["besides"])
        assert abs(int(message[1]) - 100 * at_limit.mean()) <= 0.5 + 1e-9
    assert max(shares) > 0.1


def margins_of(specification):
    """By the numeric half, of the loop with the last theta: roots, and no grid."""
    run = specification.execute().first.run
    return stability_margins(ClosedLoop(run.plant, run.compensator), disk=False)


@pytest.mark.costly
def test_margins_are_those_of_the_numeric_half(opened, monkeypatch):
    """Crossovers are bisected to float64; the two loops differ by the rounding of their poles."""
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")  # a run at the edge of the set is chaotic
    page, draw, compared = opened(), random.Random(5), 0
    for _ in range(16):
        page.locator("#scenes button").nth(draw.randrange(1 + len(SCENES))).click()
        moved_at_random(page, draw)
        settled = settle(page)
        if settled["lost"]:
            continue
        margins = margins_of(build(tomllib.loads(settled["toml"]), "page.toml").main_run)
        mine = settled["margins"]
        assert (mine is not None) == margins.is_stable
        if mine is None or margins.worst_gap > 1e-8:
            continue
        compared += 1
        assert mine["phase"] == pytest.approx(margins.phase.value, rel=1e-5)
        assert mine["down"] == pytest.approx(margins.gain_down.value, rel=1e-5, abs=1e-9)
        assert mine["up"] == pytest.approx(margins.gain_up.value, rel=1e-5)
    assert compared >= 5


@pytest.mark.costly
def test_the_prediction_is_the_exact_one(opened):
    """It is the characteristic polynomial of the matched loop, by the exact half."""
    page, observed = opened(), 0
    for number in range(1 + len(SCENES)):
        page.locator("#scenes button").nth(number).click()
        settled = settle(page)
        specification = build(tomllib.loads(settled["toml"]), "page.toml").main_run
        if settled["predicted"] is None:
            assert "No loop matches" in settled["besides"]
            continue
        observed += 1
        comparison = specification.execute().first.comparison
        expected = np.sort_complex(np.asarray(comparison.requested_poles))
        mine = np.sort_complex([complex(*pole) for pole in settled["predicted"]])
        # a root of multiplicity m is known to the m-th root of rounding
        np.testing.assert_allclose(mine, expected, atol=1e-4)
    assert observed >= 3


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.skipif(compiler() is None, reason="there is no C compiler on this machine")
@pytest.mark.parametrize("number", [0, 1, 3])
def test_theta_is_that_of_the_exported_core_bit_for_bit(opened, number):
    page = opened()
    page.locator("#scenes button").nth(number).click()
    settled = settle(page)
    settings = build(tomllib.loads(settled["toml"]), "page.toml").main_run.settings
    core = Core(core_tables(settings))
    for k in range(settled["done"]):
        assert same_bits(core.theta, settled["theta"][k])
        status, u = core.step([settled["y"][k]], [settled["z"][k]])
        assert not status & 2 and same_bits(u, [settled["u"][k]])
    assert same_bits(core.theta, settled["theta"][settled["done"]])


@pytest.mark.costly
def test_dozens_of_drags_leave_the_rings_in_the_disk_and_the_console_silent(opened, in_full):
    page, draw = opened(), random.Random(7)
    for number in range(300 if in_full else 12):
        if number % 6 == 0:
            page.locator("#scenes button").nth(number // 6 % 5).click()
            page.evaluate(DRAWN)
        if number % 5 == 0:
            button = draw.choice(["#add", "#add-pair", "#remove"])
            if page.is_enabled(button):
                page.click(button)
                page.evaluate(DRAWN)
        handles = page.locator(".handle")
        handle = handles.nth(draw.randrange(handles.count()))
        x, y, width, height = (handle.bounding_box()[k] for k in ("x", "y", "width", "height"))
        page.mouse.move(x + width / 2, y + height / 2)
        page.mouse.down()
        page.mouse.move(x + draw.uniform(-150, 150), y + draw.uniform(-150, 150), steps=3)
        page.mouse.up()
        page.evaluate(DRAWN)
        dials = page.evaluate("explorer.dials")
        assert all(np.hypot(*pole) <= 0.981 for pole in dials["poles"])
        assert all(np.hypot(*zero) >= 0.999 for zero in dials["told"])
        assert len(page.inner_text("#sentence")) > 20 and not page.inner_text("#wrong")


@pytest.mark.costly
def test_where_a_ring_is_let_go_there_it_is_asked_for(opened):
    page = opened()
    page.get_by_role("button", name="An unstable plant").click()
    page.evaluate(DRAWN)
    handle = page.locator('.handle[data-kind="poles"][data-index="1"]')
    before = settle(page)["dials"]["poles"][1]
    box, unit = handle.bounding_box(), page.locator("#handles").bounding_box()["width"] / 440
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60 * unit, y + 5)
    page.mouse.up()
    dials = settle(page)["dials"]
    assert dials["poles"][1][1] == 0  # a real pole stays real
    moved = before[0] - dials["poles"][1][0]
    # -2.18 to 1.2 are seen, in 440 units; the ring is caught a pixel beside its middle at most
    assert moved == pytest.approx(60 * 3.38 / 440, abs=2 * 3.38 / 440 / unit)


@pytest.mark.costly
def test_the_keyboard_moves_adds_and_removes_rings(opened):
    page = opened()
    page.get_by_role("button", name="An unstable plant").click()
    page.evaluate(DRAWN)
    page.focus('.handle[data-kind="poles"][data-index="0"][tabindex]')
    for key in ("ArrowRight", "ArrowUp", "Shift+ArrowLeft"):
        page.keyboard.press(key)
    (x, y), *_ = settle(page)["dials"]["poles"]
    assert (x, y) == (0.71, 0.21)
    focused = "document.activeElement.getAttribute('aria-valuetext')"
    assert page.evaluate(focused) == "0.71 ± 0.21j"
    page.keyboard.press("Delete")
    assert settle(page)["dials"]["poles"] == [[0.8, 0]]
    page.focus("#add-pair")
    page.keyboard.press("Enter")
    assert settle(page)["dials"]["poles"] == [[0.8, 0], [0.4, 0.4]]
    page.focus("#n_c")
    page.keyboard.press("ArrowRight")
    assert settle(page)["dials"]["n_c"] == 4


@pytest.mark.costly
def test_a_finger_moves_a_ring_and_not_the_page(opened):
    page = opened(390, touch=True)
    page.get_by_role("button", name="An unstable plant").click()
    page.evaluate(DRAWN)
    handle = page.locator('.handle[data-kind="poles"][data-index="1"]')
    handle.scroll_into_view_if_needed()
    before = settle(page)["dials"]["poles"][1]
    plane = page.locator("#handles")
    top = plane.bounding_box()["y"]  # in the window
    box = handle.bounding_box()
    assert min(box["width"], box["height"]) >= 44  # as wide as a finger
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = page.context.new_cdp_session(page)

    def send(kind, *points):
        places = [{"x": a, "y": b} for a, b in points]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    send("touchStart", (x, y))
    for part in (10, 20, 30, 40):
        send("touchMove", (x - part, y + part))
    send("touchEnd")
    assert settle(page)["dials"]["poles"][1][0] < before[0] - 0.1
    assert plane.bounding_box()["y"] == pytest.approx(top, abs=1)


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_wider_than_the_window(opened, scheme):
    page = opened(scheme=scheme)
    page.click("summary")
    for width in (320, 390, 1280, 1920):
        page.set_viewport_size({"width": width, "height": 900})
        for number in range(1 + len(SCENES)):
            page.locator("#scenes button").nth(number).evaluate("button => button.click()")
            page.evaluate(DRAWN)
            assert page.evaluate("document.documentElement.scrollWidth") == width
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert paper == ("rgb(255, 255, 255)" if scheme == "light" else "rgb(19, 21, 25)")


@pytest.mark.costly
def test_the_pictures_hold_lines_in_both_schemes(opened):
    page = opened()
    ink = """id => {
      const shown = document.getElementById(id), copy = document.createElement("canvas");
      [copy.width, copy.height] = [shown.width, shown.height];
      const pen = copy.getContext("2d", { willReadFrequently: true });
      pen.drawImage(shown, 0, 0);
      const { data } = pen.getImageData(0, 0, copy.width, copy.height);
      return data.filter((value, i) => i % 4 === 3 && value).length;
    }"""
    for _ in range(2):
        assert all(page.evaluate(ink, name) > 300 for name in ("z", "u", "theta", "plane"))
        page.click("#theme")
        page.evaluate(DRAWN)


WRONG = {
    "(q + 2": "parenthesis",
    "(q + 2)/(q + 2)/q": "share a factor",
    "q**2/(q - 0.5)": "strictly proper",
    "q + x": "Only numbers",
    "": "Something is missing",
    "1/(q - q)": "denominator is zero",
    "0/(q - 0.5)": "G = 0",
    "1/q^13": "up to 12",
}


@pytest.mark.costly
def test_a_wrong_formula_is_one_line_and_the_last_picture_stays(opened):
    page = opened()
    before = settle(page)
    for text, words in WRONG.items():
        page.fill("#G", text)
        after = settle(page)
        assert words in after["wrong"] and after["z"] == before["z"]
        assert page.get_attribute("#G", "aria-invalid") == "true"
    page.fill("#G", "0.5/(q - 0.5)")
    assert not settle(page)["wrong"] and page.get_attribute("#G", "aria-invalid") is None


@pytest.mark.costly
def test_a_typed_plant_is_told_its_zeros_and_keeps_them_in_its_file(opened, monkeypatch):
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")
    page = opened()
    page.fill("#G", "2(q - 1.5)(q + 0.25)/((3q - 1)(q^2 - .8q + 0.52))")
    settled = settle(page)
    assert settled["dials"]["told"] == [[1.5, 0]]
    specification = as_simulated(settled)
    numerator, denominator = specification.plant.scalar_map("zu")
    assert (numerator.LC(), denominator.degree()) == (Fraction(2, 3), 3)


@pytest.mark.costly
def test_the_words_of_a_file_are_words(opened):
    page = opened()
    assert "</script><b>Mine</b>" in page.inner_text("#scenes")
    assert page.locator("#scenes b").count() == 0


@pytest.mark.costly
def test_the_sentence_says_what_happened(opened):
    page = opened()

    def said(name):
        page.get_by_role("button", name=name).click()
        return settle(page)["sentence"]

    assert "all 3 requested poles are reached" in said("An unstable plant")
    diverged = r"Diverged at step \d+\. RCAC cancels the unknown nonminimum-phase zero −2"
    assert re.match(diverged, said("A zero that RCAC does not know"))
    page.get_by_role("button", name="An unstable plant").click()
    page.evaluate(MOVE, ["amplitude", 0.0])
    assert "RCAC cannot learn" in settle(page)["sentence"]
    page.get_by_role("button", name="An unstable plant").click()
    page.evaluate(MOVE, ["gain", 0.0])
    assert "sign of the gain" in settle(page)["sentence"]


@pytest.mark.costly
def test_a_track_is_painted_by_what_each_place_comes_to(opened):
    page = opened()
    page.get_by_role("button", name="An unstable plant").click()
    page.wait_for_selector('#k_w-track[style*="gradient"]', state="attached")  # the last one
    track = page.evaluate("document.getElementById('n_c-track').style.background")
    kinds = re.findall(r"--(\w+)", track)
    assert len(kinds) == len(ORDERS)
    for n_c, kind in zip(ORDERS, kinds, strict=True):
        page.evaluate("([n, of]) => { const s = document.getElementById('n_c'); s.value = n;"
                      "s.dispatchEvent(new Event('input')); }", [n_c, 4])  # fmt: skip
        now = settle(page)["kind"]
        assert kind == {"reached": "good", "stable": "warning"}.get(now, "bad")


# ---- the modules that need no document


def test_numbers_are_rounded_once(scripts):
    draw = random.Random(1)
    argument = [
        (draw.randrange(-(10**a), 10**a), draw.randrange(1, 10**b))
        for a, b in ((3, 3), (20, 3), (3, 25), (40, 40), (17, 17))
        for _ in range(200)
    ]
    argument += [(2**53 + 1, 1), (2**54 + 3, 2), (-(2**60) - 129, 1), (1, 10**300)]  # ties, tiny
    evaluation = scripts.evaluate(
        "rows => rows.map(([n, d]) => known.rounded(known.rational(BigInt(n), BigInt(d))))",
        [[str(n), str(d)] for n, d in argument],
    )
    assert same_bits(evaluation, [float(Fraction(n, d)) for n, d in argument])


def test_decimals_are_read_and_written_exactly(scripts):
    texts = ["0.1", "-2", "1e-40", "5/3", "1.250", "0", "12e3", "-0.000123", ".5"]
    evaluation = scripts.evaluate("texts => texts.map(t => known.written(known.exactly(t)))", texts)
    assert [Fraction(text) for text in evaluation] == [Fraction(text) for text in texts]


@pytest.mark.costly
@pytest.mark.parametrize(
    "text",
    ["(q + 2)/(q^2 - 2q + 1.04)", "1/(3q - 1)", "-(q-.5)(q+3)/q**3", "2/(q-1) - 1/(q - 0.25)",
     "(q^2 - 1.44*q + 0.81)/((q - 0.9)(q^2 - 1.71q + 0.903))", "1e-3*(z+1)/(z*(z-1))/2"],
)  # fmt: skip
def test_a_formula_is_read_as_python_reads_it(scripts, text):
    evaluation = scripts.evaluate(
        "t => known.transferFunction(t).map(p => p.map(known.rounded))", text
    )
    words = re.sub(r"(?<=[\d)])(?=[qz(])|(?<=[qz])(?=\()", "*", text).replace("^", "**")
    read = exact.transfer_function(words)
    lead = read.denominator.LC()
    for part, poly in zip(evaluation, (read.numerator, read.denominator), strict=True):
        assert same_bits(part, rounded([c / lead for c in poly.all_coeffs()], "p"))


@pytest.mark.costly
def test_roots_are_as_good_as_their_coefficients(scripts):
    """The residual of each root is a few roundings of the polynomial's terms, in 40 digits."""
    generator = np.random.default_rng(4)
    polynomials = [[1.0, *generator.normal(size=n)] for n in range(1, 17) for _ in range(5)]
    polynomials += [[1, 0, 0, 0], [1, -2, 1.04, 0, 0], [2, -3.2, 1.5, 1e-12]]
    evaluation = scripts.evaluate("ps => ps.map(p => known.rootsOf(p))", polynomials)
    with mpmath.workdps(40):
        for p, roots in zip(polynomials, evaluation, strict=True):
            assert len(roots) == len(p) - 1
            for x, y in roots:
                root, n = mpmath.mpc(x, y), len(p) - 1
                terms = [abs(c) * abs(root) ** (n - i) for i, c in enumerate(p)]
                # Horner's error is below 2 n eps of the terms' sum, and a complex product's
                # below sqrt(8) eps; what it cannot see is no root's fault.
                bound = 8 * n * np.finfo(float).eps * mpmath.fsum(terms)
                assert abs(mpmath.polyval(p, root)) <= bound + mpmath.mpf(10) ** -300


def test_the_pole_that_is_missed_is_that_which_no_pole_is_near(scripts):
    far = scripts.evaluate(
        "known.distances([[0.5, 0], [0.5, 0], [0, 1]], [[0, 1], [0.5, 0], [0.9, 0], [3, 0]])"
    )
    assert far[2] == 0 and sorted(far[:2]) == [0, pytest.approx(0.4, abs=1e-15)]


def test_poles_are_judged_by_the_polynomial_and_not_by_multiple_roots(scripts):
    """As ExactComparison does: copies of a root are far apart where the coefficients agree."""
    of = "([wanted, found]) => known.backwardError(wanted, found)"
    roots = np.roots(np.poly([0.5, 0.5, 0.5, -0.3]) + 1e-9 * np.array([0, 1, 1, 1, 1]))
    split = [[root.real, root.imag] for root in roots]
    assert (
        max(scripts.evaluate("([w, f]) => known.distances(w, f)", [[[0.5, 0]] * 3, split])) > 4e-4
    )
    assert scripts.evaluate(of, [[[0.5, 0]] * 3, split]) < 1e-7
    circle = np.exp(1j * np.linspace(0, np.pi, 4001))
    change = np.abs(0.06 / np.maximum(np.abs(circle - 0.4), np.abs(circle - 0.46))).max()
    evaluation = scripts.evaluate(of, [[[0.4, 0]], [[0.46, 0], [0.9, 0]]])
    assert abs(evaluation - change) < 1e-4 * change
    assert scripts.evaluate("f => known.backwardError([[0, 0], [0, 0]], f) === Infinity", [[0, 0]])


@pytest.mark.costly
def test_a_notebook_shows_the_same_page_in_a_frame(browser, tmp_path):
    """Its script runs and its own alone; it moves, and asks for nothing."""
    shown = explore(own())
    assert "<script>" not in shown._repr_html_() and "own" not in repr(shown)
    file = tmp_path / "notebook.html"
    file.write_text(f"<!DOCTYPE html><title>notebook</title>{shown._repr_html_()}")
    page, wrong = browser.new_page(), []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda r: r.url.startswith(("file:", "about:")) or wrong.append(r.url))
    page.goto(file.as_uri())
    frame = page.frames[1]
    frame.wait_for_selector("[data-ready]")
    before = frame.inner_text("#sentence")
    frame.evaluate(MOVE, ["gain", 0.05])
    frame.evaluate(DRAWN)
    assert frame.inner_text("#sentence") != before and not wrong
    shown.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == shown.text
    page.close()


def test_a_case_that_is_no_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"no\.toml"):
        explore(tmp_path / "no.toml")
    with pytest.raises(InputError, match="belongs to a case"):
        explore(run="main")
