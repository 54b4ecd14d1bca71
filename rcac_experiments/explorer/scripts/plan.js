// From the dials to what the core is given: every coefficient exact, and rounded once.
import { ONE, exactly, inWords, multiply, over, rounded, scaled, shifted, times, withRoots } from "./rationals.js";
import { transferFunction } from "./formulas.js";
import { rootsOf } from "./roots.js";

const read = new Map();  // the last plants that were typed
function plantOf(text) {
  if (!read.has(text)) {
    if (read.size > 50) read.clear();
    read.set(text, transferFunction(text));
  }
  return read.get(text);
}

// G with its delay; a q of the numerator takes one step of the delay away.
export function exactPlant(dials) {
  let [numerator, denominator] = plantOf(dials.G), delay = dials.delay;
  while (delay > 0 && numerator.length > 1 && numerator.at(-1)[0] === 0n) {
    numerator = numerator.slice(0, -1);
    delay -= 1;
  }
  return [numerator, shifted(denominator, delay)];
}

export const isServo = dials => dials.signal === "command" || (dials.signal === "file" && dials.problem === "servo");

// H of G_zu as RCAC is told it, and the relative degree.
export function modelling(dials) {
  const [numerator, denominator] = exactPlant(dials);
  const sign = isServo(dials) ? [-1n, 1n] : ONE;
  return {
    H: times(times(sign, numerator[0]), exactly(dials.gain)),
    d_zu: Math.max(1, denominator.length - numerator.length + dials.d_zu),
  };
}

// Whether what RCAC is told of the first coefficient and the relative degree is so.
export const isExact = dials => {
  const [numerator, denominator] = exactly(dials.gain);
  return numerator === denominator && dials.d_zu === 0;
};

// The target model H q^(n_p - d_zu - deg N) N / D_p, (4.39).
export function targetModel(dials) {
  const { H, d_zu } = modelling(dials), N = withRoots(dials.told), D = withRoots(dials.poles);
  const surplus = D.length - 1 - d_zu - (N.length - 1);
  return [shifted(scaled(N, H), Math.max(surplus, 0)), shifted(D, Math.max(-surplus, 0))];
}

// The ellipsoid of the case, on the plant, the signs and the order that it is for; else null.
export function ellipsoidOf(dials) {
  const { ellipsoid, home } = dials;
  return ellipsoid.center && home.n_c === dials.n_c && home.isServo === isServo(dials) && home.G === plantInWords(dials) ? ellipsoid : null;
}
export const plantInWords = dials => exactPlant(dials).map(inWords).join(" / ");

export function planOf(dials, room) {
  const [numerator, denominator] = exactPlant(dials), [N_f, D_f] = targetModel(dials);
  const n = denominator.length - 1, n_f = D_f.length - 1, servo = isServo(dials);
  if (n > room.states) throw new Error(`The plant has ${n} states; ${room.states} are the most here.`);
  if (n_f > room.order) throw new Error(`The target model has order ${n_f}; ${room.order} is the most here.`);
  const num = numerator.map(rounded), den = denominator.map(rounded);
  // The controllable canonical form, with w = [w] at the input, or [r; d; v].
  const l_w = servo ? 3 : 1, width = n + 1 + l_w, rows = new Float64Array((n + 2) * width);
  for (let i = 0; i < n - 1; i += 1) rows[i * width + i + 1] = 1;
  for (let j = 0; j < n; j += 1) rows[(n - 1) * width + j] = -den[n - j] + 0;
  rows[(n - 1) * width + n] = 1;
  rows[(n - 1) * width + n + 1 + (servo ? 1 : 0)] = 1;
  for (const row of [n, n + 1]) {
    num.toReversed().forEach((c, j) => { rows[row * width + j] = servo ? -c : c; });
    if (servo) [rows[row * width + n + 1], rows[row * width + n + 3]] = [1, -1];
  }
  const ellipsoid = ellipsoidOf(dials);
  const shortest = Math.max(dials.n_c, n_f);
  const behind = p => Float64Array.from({ length: room.order + 1 }, (_, i) => p[i] ?? 0);
  return {
    dials, num, den, n, l_w, rows, servo, n_f, width,
    k_w: Math.min(Math.max(dials.k_w, shortest), dials.steps - 1),
    numerator: behind([...new Array(n_f + 1 - N_f.length).fill(0), ...N_f.map(rounded)]),
    denominator: behind(D_f.map(rounded)),
    D_0: 1 / Number(dials.R_theta),
    lambda: Number(dials.lambda),
    theta_0: dials.n_c === dials.home.n_c ? dials.theta_0 : new Array(2 * dials.n_c).fill(0),
    ellipsoid,
    isKept: dials.kept && ellipsoid !== null,
    bound: dials.bound === "none" ? Infinity : Number(dials.bound),
    zeros: rootsOf(num),
    poles: rootsOf(den),
  };
}

// The zeros of G on or outside the unit circle, which RCAC has to be told.
export const nonminimumPhase = num => rootsOf(num)
  .filter(([x, y]) => y >= 0 && Math.hypot(x, y) >= 1 - 1e-9)
  .map(root => root.map(part => Number(part.toFixed(12))));
