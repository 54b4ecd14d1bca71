// The exported core as WebAssembly, around the plant.
import { convolved, rootsOf, summed } from "./roots.js";

const bytesOf = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
export const numbersOf = text => new Float64Array(bytesOf(text).buffer);

// A module for each order n_c.
export async function openCores({ orders, lengths, deflated }) {
  const stream = new Blob([bytesOf(deflated)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const code = await new Response(stream).arrayBuffer(), cores = new Map();
  let first = 0;
  for (const [i, n_c] of orders.entries()) {
    const { instance } = await WebAssembly.instantiate(code.slice(first, first + lengths[i]), {});
    if (instance.exports.self_check() & ~16) throw new Error("This browser does not round as C says.");
    cores.set(n_c, instance.exports);
    first += lengths[i];
  }
  return cores;
}
export const roomOf = core => ({ steps: core.room(0), states: core.room(1), order: core.room(2) });

// w, one row for each step: the numbers that `exogenous` makes of the settings that are handed back.
export function exogenousInput(dials, data, channels) {
  const { steps } = dials;
  if (dials.signal === "file") return numbersOf(dials.w).slice(0, steps * channels);
  const w = new Float64Array(steps * channels), size = Number(dials.amplitude), noise = Number(dials.noise);
  const drawn = data.draws[dials.seed];  // two columns: of channel 0 and of channel 1
  for (let k = 0; k < steps; k += 1) {
    if (dials.signal === "command") {
      w[3 * k] = size;
      w[3 * k + 1] = noise ? noise * drawn[2 * k + 1] : 0;
    } else {
      const base = dials.signal === "step" ? size : dials.signal === "wave" ? size * data.wave[k] : 0;
      w[k] = noise ? base + noise * drawn[2 * k] : base;
    }
  }
  return w;
}

const NO_DIGIT_LEFT = 1e15;

// `cores`: of the orders n_c, free and in an ellipsoid.
export function run(cores, plan, w) {
  const core = (plan.isKept ? cores.ellipsoidal : cores.free).get(plan.dials.n_c);
  const { dials, n } = plan, { n_c, steps } = dials, l_theta = 2 * n_c, buffer = core.memory.buffer;
  const at = (address, count) => new Float64Array(buffer, address, count);
  at(core.plant_rows(), plan.rows.length).set(plan.rows);
  at(core.exogenous(), w.length).set(w);
  at(core.table(0), l_theta).fill(plan.D_0);
  at(core.table(1), plan.numerator.length).set(plan.numerator);
  at(core.table(2), plan.denominator.length).set(plan.denominator);
  at(core.table(3), 1)[0] = plan.lambda;
  at(core.table(4), l_theta).set(plan.theta_0);
  if (plan.isKept) place(core, plan.ellipsoid);
  core.start_at(plan.k_w);
  core.saturate_at(plan.bound);
  const scale = w.reduce((most, value) => Math.max(most, Math.abs(value)), 1);
  const done = core.run(steps, n, plan.l_w, NO_DIGIT_LEFT * scale), rows = Math.min(done + 1, steps);
  return {
    plan, w, done, lost: done < steps,
    z: at(core.recorded(0), rows).slice(),
    u: at(core.recorded(1), rows).slice(),
    y: at(core.recorded(2), rows).slice(),
    theta: at(core.recorded(3), (done + 1) * l_theta).slice(),
    l_theta,
    // theta of these steps is projected
    projected: plan.isKept ? new Uint8Array(buffer, core.moved(), rows).slice().fill(0, 0, 1) : null,
  };
}

function place(core, { center, inverse, radii }) {
  for (const [which, values] of [center, inverse, radii].entries())
    new Float64Array(core.memory.buffer, core.ellipsoid(which), values.length).set(values);
}

// e(k), the share of the radius of the ellipsoid that theta(k) uses; above 1 outside.
export function sharesOf(cores, { plan, theta, l_theta }) {
  if (!plan.ellipsoid) return null;
  const core = cores.ellipsoidal.get(plan.dials.n_c), count = theta.length / l_theta;
  place(core, plan.ellipsoid);
  new Float64Array(core.memory.buffer, core.recorded(3), theta.length).set(theta);
  return new Float64Array(core.memory.buffer, core.radii(count), count).slice();
}

export const appliedOf = ({ u, plan: { bound } }) => u.map(value => Math.min(Math.max(value, -bound), bound));

// D_c and N_c of the compensator that theta of step k is, (2.28).
export function compensatorAt({ plan, theta, l_theta, done }, k) {
  const at = Math.min(k, done) * l_theta, n_c = plan.dials.n_c;
  const D_c = [1], N_c = [];
  for (let i = 0; i < n_c; i += 1) {
    D_c.push(-theta[at + i]);
    N_c.push(theta[at + n_c + i]);
  }
  return [D_c, N_c];
}

// The closed-loop polynomial with theta of step k held: D D_c - N N_c, (2.28); of the servo problem plus.
export function closedLoop(found, k) {
  const { plan } = found, [D_c, N_c] = compensatorAt(found, k);
  return summed(convolved(plan.den, D_c), convolved(plan.num, N_c), plan.servo ? 1 : -1);
}
export const polesAt = (found, k, near = null) => rootsOf(closedLoop(found, k), near);
