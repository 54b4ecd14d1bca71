// The page: dials, pictures and the sentence above them.
import { colours, lines, span, stepAt } from "./charts.js";
import { appliedOf, exogenousInput, numbersOf, openCores, polesAt, roomOf, run, sharesOf } from "./loop.js";
import { marginsAt, predicted } from "./margins.js";
import { Plane, allowed } from "./plane.js";
import { exactPlant, isServo, nonminimumPhase, planOf, plantInWords } from "./plan.js";
import { inWords, rounded } from "./rationals.js";
import { asToml } from "./settings.js";
import { besides, known, ofTheSet, outcomeOf, sentence, shown } from "./words.js";

const get = id => document.getElementById(id);
const given = JSON.parse(get("explorer-data").textContent);
const data = {
  wave: numbersOf(given.wave),
  draws: Object.fromEntries(Object.entries(given.draws).map(([seed, text]) => [seed, numbersOf(text)])),
};
const COLOURS = ["ink", "quiet", "line", "shade", "bad", "good", "warning", "c1", "c4", "c5"];
const power = v => `1e${v}`;
const SLOW = 120;  // ms after the last change until tracks are painted
const SLICE = 6;  // ms of painting between two chances for a hand to be heard
const HIGHEST_SHARE = 4;  // of the picture of e(k)
const PLACES = 61;  // of a track, at most

// id, the least, the most, the step, from the slider to the dial and back, what is shown.
const exponent = text => Math.round(Math.log10(Number(text)));
const UNBOUNDED = 3;  // the right end of a dial of exponents
const DIALS = [
  { key: "R_theta", min: -40, max: 4, to: power, from: exponent, painted: true },
  { key: "n_c", min: 1, max: Math.max(...given.core.orders), to: Number, from: Number, painted: true },
  { key: "gain", min: -2, max: 4, step: 0.1, to: v => String(Number(v)), from: v => fraction(v), painted: true },
  { key: "delay", min: 0, max: 6, to: Number, from: Number, painted: true },
  { key: "d_zu", min: -2, max: 4, to: Number, from: Number, painted: true },
  { key: "noise", min: 0, max: 0.1, step: 0.001, to: v => String(Number(v)), from: Number, painted: true },
  { key: "amplitude", min: 0, max: 2, step: 0.01, to: v => String(Number(v)), from: Number },
  { key: "bound", min: -2, max: UNBOUNDED, step: 0.1, painted: true,
    to: v => Number(v) >= UNBOUNDED ? "none" : String(Number((10 ** v).toPrecision(2))),
    from: text => text === "none" ? UNBOUNDED : Math.log10(Number(text)) },
  { key: "lambda", min: 0.95, max: 1, step: 0.001, to: v => String(Number(v)), from: Number, painted: true },
  { key: "k_w", min: 1, max: 150, to: Number, from: Number, painted: true },
  { key: "steps", min: 40, max: 600, step: 20, to: Number, from: Number },
];
const fractional = text => text.includes("/") || text === "none" ? text
  : Number(text) && Math.abs(Number(text)) < 1e-3 ? Number(text).toExponential() : String(Number(text));
const fraction = text => text.includes("/") ? text.split("/").reduce((a, b) => a / b) : Number(text);

let cores, room, colour, dials, found, outcome, trail, cursor = Infinity, queued = 0, isNew = false, painting = 0;
const plane = new Plane(get("plane"), get("handles"), moved);

function moved(kind, index, point, by = null) {
  const before = dials[kind][index];
  const wanted = point ?? [before[0] + by[0], before[1] + by[1]];
  dials[kind][index] = allowed(kind, wanted, before[1] > 0);
  cursor = Infinity;
  change();
}

function compute() {
  const plan = planOf(dials, room);
  found = run(cores, plan, exogenousInput(dials, data, plan.l_w));
  found.shares = sharesOf(cores, found);
  found.applied = appliedOf(found);
  outcome = outcomeOf(found);
  trail = [];
  let near = null;
  const last = found.lost ? Math.floor(0.6 * found.done) : found.done;
  for (let i = 0; i <= 36; i += 1) {
    const k = Math.round(plan.k_w + Math.max(0, last - plan.k_w) * (i / 36) ** 2);
    near = polesAt(found, k, near);
    trail.push(near);
  }
}

// Where a run is lost its last part would flatten the rest of the picture.
const seen = () => found.lost ? Math.max(2, Math.floor(0.72 * found.done)) : found.z.length;

function draw() {
  const { plan } = found, last = found.lost ? Math.max(0, seen() - 1) : found.z.length - 1;
  const k = Math.min(cursor, last), n_c = dials.n_c;
  const marks = found.projected?.subarray(0, found.z.length);
  const common = { steps: dials.steps, colour, start: plan.k_w, cursor: k, end: found.lost ? found.done : dials.steps };
  const count = found.z.length, picture = (id, series, [low, high], axis, marks) =>
    lines(get(id), series, { low, high, axis, marks, ...common });
  picture("z", [{ values: found.z, count, colour: colour.c1, thick: 2 }], span(found.z, seen(), true), true);
  const asked = { values: found.u, count, colour: colour.quiet }, applied = { values: found.applied, count, colour: colour.c5 };
  picture("u", Number.isFinite(plan.bound) ? [asked, applied] : [applied], span(found.applied, seen(), true), false);
  const theta = Array.from({ length: found.l_theta }, (_, i) => ({
    values: found.theta, count, stride: found.l_theta, first: i, colour: i < n_c ? colour.c5 : colour.c1, thick: 1.4,
  }));
  picture("theta", theta, span(found.theta, seen() * found.l_theta, false), false);
  get("of-share").hidden = !found.shares;
  if (found.shares) {
    const most = found.shares.subarray(0, seen()).reduce((a, b) => Math.max(a, b), 0);
    picture("share", [
      { values: new Float64Array(dials.steps).fill(1), count: dials.steps, colour: colour.c4, thick: 1.2 },
      { values: found.shares, count, colour: colour.c1, thick: 1.6 },
    ], [0, Math.min(Math.max(1.15, 1.05 * most), HIGHEST_SHARE)], false, marks);
    get("share-out").textContent = `e(${k}) = ${found.shares[k].toPrecision(3)}${marks?.[k] ? ", projected" : ""}`;
  }
  const poles = cursor >= last && !found.lost ? outcome.poles : polesAt(found, k);
  const theory = predicted(plan);
  plane.draw({ dials, plan, poles, trail, theory: theory ?? [] }, colour);
  get("besides").textContent = besides(found, poles, marginsAt(found, k >= last && !found.lost ? found.done : k), theory);
  const scrubber = get("cursor");
  scrubber.max = last;
  scrubber.value = k;
  scrubber.setAttribute("aria-valuetext", `step ${k}, z = ${found.z[k].toPrecision(3)}`);
  get("cursor-out").textContent = `k = ${k}`;
}

function elements(parts) {
  return parts.map(([words, level]) => {
    if (!level) return words;
    const part = document.createElement("span");
    part.className = level;
    part.textContent = words;
    return part;
  });
}

let speaking = 0;
function speak() {
  get("sentence").replaceChildren(...elements(sentence(found, outcome)));
  get("known").textContent = known(found.plan);
  clearTimeout(speaking);
  speaking = setTimeout(() => { get("spoken").textContent = get("sentence").textContent; }, 700);
  get("poles-list").textContent = outcome.wanted.length
    ? `Asked for: ${dials.poles.map(shown).join(", ")}. The loop has: ${outcome.poles.filter(([, y]) => y >= 0).map(shown).join(", ")}.` : "";
  get("of-set").textContent = ofTheSet(found, found.shares);
  get("toml").value = asToml(dials, room, found.lost);
}

function change(whole = true) {
  isNew ||= whole;
  queued ||= requestAnimationFrame(() => {
    queued = 0;
    if (isNew) {
      isNew = false;
      try {
        compute();
        complain("");
      } catch (error) {
        complain(error.message);
        return;
      }
      const place = get("handles"), top = place.getBoundingClientRect().top;
      speak();
      // A sentence of another length must not move a ring from under a finger.
      if (plane.held) scrollBy({ top: place.getBoundingClientRect().top - top, behavior: "instant" });
      clearTimeout(painting);
      painting = setTimeout(paint, SLOW);
    }
    show();
    draw();
  });
}

function complain(words) {
  get("wrong").textContent = words;
  if (words) get("G").setAttribute("aria-invalid", "true");
  else get("G").removeAttribute("aria-invalid");
}

// ---- under each slider what each of its values would come to, in idle moments

const OUTCOMES = { reached: "--good", stable: "--warning", unstable: "--bad", lost: "--bad" };

function paint() {
  const job = painting, at = dials, list = DIALS.filter(dial => dial.painted && !get(dial.key).disabled);
  let number = 0, kinds = [];
  (function next() {
    const end = performance.now() + SLICE;
    while (job === painting && at === dials && number < list.length && performance.now() < end) {
      const { key, to } = list[number], slider = get(key);
      const [min, max, step] = [slider.min, slider.max, slider.step].map(Number);
      const places = Math.min(PLACES, Math.round((max - min) / step) + 1);
      const exact = min + Math.round((max - min) * kinds.length / Math.max(1, places - 1) / step) * step;
      kinds.push(kindWith({ ...dials, [key]: to(Number(exact.toFixed(6))) }));
      if (kinds.length < places) continue;
      get(`${key}-track`).style.background = `linear-gradient(90deg, ${kinds.map((kind, i) =>
        `var(${OUTCOMES[kind] ?? "--line"}) ${100 * i / places}% ${100 * (i + 1) / places}%`).join(", ")})`;
      const reached = kinds.filter(kind => kind === "reached").length;
      slider.setAttribute("aria-description", `reaches the poles in ${reached} of ${places} places of the track`);
      [number, kinds] = [number + 1, []];
    }
    if (job === painting && at === dials && number < list.length) setTimeout(next, 0);
  })();
}

function kindWith(others) {
  try {
    const plan = planOf(others, room);
    return outcomeOf(run(cores, plan, exogenousInput(others, data, plan.l_w))).kind;
  } catch {
    return "none";
  }
}

// ---- what the dials show

function show() {
  const isFile = dials.signal === "file", { plan } = found;
  get("d_zu").min = plan.num.length - plan.n;  // RCAC is told 1 at least
  for (const { key, from } of DIALS) {
    const slider = get(key), now = from(dials[key]);
    if (document.activeElement !== slider || Number(slider.value) !== now) {
      if (now > slider.max) slider.max = now;
      if (now < slider.min) slider.min = now;
      slider.value = now;
    }
    const words = (key === "k_w" ? String(plan.k_w) : fractional(String(dials[key]))).replaceAll("-", "−");
    get(`${key}-out`).textContent = key === "d_zu" && dials.d_zu > 0 ? `+${words}` : words;
    slider.setAttribute("aria-valuetext", get(`${key}-out`).textContent);
    slider.disabled = isFile && ["noise", "amplitude", "steps"].includes(key);
  }
  get("kept").checked = plan.isKept;
  get("kept").disabled = !plan.ellipsoid;
  if (document.activeElement !== get("G")) get("G").value = dials.G;
  get("signal").value = dials.signal;
  for (const button of get("scenes").children) button.setAttribute("aria-pressed", String(button.dataset.name === dials.title));
  get("remove").disabled = dials.poles.length < 2 && plane.selected?.kind !== "told";
}

function load(scene) {
  dials = structuredClone(scene);
  const [numerator, denominator] = exactPlant(dials);
  [dials.G, dials.delay] = [`(${inWords(numerator)})/(${inWords(denominator)})`, 0];
  dials.home = { n_c: dials.n_c, isServo: isServo(dials), G: plantInWords(dials) };
  for (const name of ["center", "inverse", "radii", "factor"])
    if (dials.ellipsoid[name]) dials.ellipsoid[name] = numbersOf(dials.ellipsoid[name]);
  cursor = Infinity;
  plane.selected = null;
  get("signal").querySelector("[value=file]").hidden = !dials.w;
  for (const { key, min, max, step = 1 } of DIALS) Object.assign(get(key), { min, max, step });
  for (const track of document.querySelectorAll(".track")) track.style.background = "none";
  typed();
}

// After another plant: the zeros that RCAC has to know are those of the plant, but in a scene.
function typed(tell = false) {
  try {
    const [numerator, denominator] = exactPlant(dials), num = numerator.map(rounded);
    if (tell) dials.told = nonminimumPhase(num);
    const plan = planOf(dials, room);
    plane.fit([...plan.zeros, ...plan.poles, ...dials.told, [denominator.length * 0, 0]]);
  } catch (error) {
    complain(error.message);
    return;
  }
  change();
}

function listen() {
  for (const { key, to } of DIALS) {
    get(key).addEventListener("input", event => {
      dials[key] = to(event.target.value);
      if (key !== "steps" && key !== "k_w") cursor = Infinity;
      if (key === "delay") typed();
      else change();
    });
  }
  get("G").addEventListener("input", event => { dials.G = event.target.value; cursor = Infinity; typed(true); });
  get("signal").addEventListener("change", event => {
    dials.signal = event.target.value;
    if (dials.signal === "file") {
      const scene = given.cases.find(one => one.title === dials.title);
      dials.steps = scene.steps;
    }
    cursor = Infinity;
    change();
  });
  get("kept").addEventListener("change", event => { dials.kept = event.target.checked; cursor = Infinity; change(); });
  get("cursor").addEventListener("input", event => { cursor = Number(event.target.value); change(false); });
  for (const id of ["z", "u", "theta", "share"]) {
    get(id).addEventListener("pointermove", event => {
      if (event.pointerType === "touch") return;
      cursor = stepAt(event.currentTarget, event.clientX, dials.steps);
      change(false);
    });
    get(id).addEventListener("pointerleave", () => { cursor = Infinity; change(false); });
  }
  get("add").addEventListener("click", () => addRing([0.5, 0]));
  get("add-pair").addEventListener("click", () => addRing([0.4, 0.4]));
  get("remove").addEventListener("click", removeRing);
  get("handles").addEventListener("keydown", event => {
    if (event.key === "Delete" || event.key === "Backspace") { event.preventDefault(); removeRing(); }
  });
  get("copy").addEventListener("click", async event => {
    const button = event.currentTarget, before = "Copy";
    get("toml").closest("details").open = true;
    try {
      await navigator.clipboard.writeText(get("toml").value);
      button.textContent = "Copied";
    } catch {
      get("toml").select();
      button.textContent = "Selected";
    }
    setTimeout(() => { button.textContent = before; }, 1500);
  });
  const renewed = () => { colour = colours(COLOURS); draw(); };
  get("theme").addEventListener("click", renewed);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", renewed);
  new ResizeObserver(() => change(false)).observe(get("content"));
}

const LARGEST_COUNT = 8;
function addRing(pole) {
  if (dials.poles.length >= LARGEST_COUNT) { complain(`${LARGEST_COUNT} rings are the most here.`); return; }
  dials.poles = [...dials.poles, pole];
  plane.selected = { kind: "poles", index: dials.poles.length - 1 };
  cursor = Infinity;
  change();
}
function removeRing() {
  const { kind, index } = plane.selected ?? { kind: "poles", index: dials.poles.length - 1 };
  if (kind === "poles" && dials.poles.length < 2) return;
  dials[kind] = dials[kind].filter((_, i) => i !== index);
  plane.selected = null;
  cursor = Infinity;
  change();
}

async function start() {
  try {
    cores = { free: await openCores(given.core), ellipsoidal: await openCores(given.ellipsoidal) };
  } catch (error) {
    get("sentence").textContent = `This browser does not run WebAssembly here: ${error.message}`;
    return;
  }
  room = roomOf(cores.free.values().next().value);
  colour = colours(COLOURS);
  get("scenes").replaceChildren(...given.cases.map(scene => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = button.dataset.name = scene.title;
    button.addEventListener("click", () => load(scene));
    return button;
  }));
  listen();
  load(given.cases[0]);
  globalThis.explorer = {  // for a console, and for tests
    get dials() { return dials; },
    get found() { return found; },
    get outcome() { return outcome; },
    get margins() { return marginsAt(found, found.done); },
    get predicted() { return predicted(found.plan); },
    load, change, compute,
  };
  document.documentElement.dataset.ready = "true";
}
start();
