// The margins of the loop with theta held, opened at u, and where theory says that its poles must lie.
import { convolved, modulus, rootsOf, summed, withConjugates } from "./roots.js";
import { compensatorAt } from "./loop.js";
import { isExact } from "./plan.js";

const GRID = 512;  // frequencies between 0 and pi, besides those near poles
const AROUND = [-30, -10, -5, -3, -2, -1.4, -1, -0.7, -0.4, -0.2, 0, 0.2, 0.4, 0.7, 1, 1.4, 2, 3, 5, 10, 30];
const SAME = 1e-6;  // a zero that RCAC is told is the plant's to as much

const valueAt = (p, omega) => {
  const [c, s] = [Math.cos(omega), Math.sin(omega)];
  let [re, im] = [0, 0];
  for (const a of p) [re, im] = [re * c - im * s + a, re * s + im * c];
  return [re, im];
};

// L with 1 + L = 0 on the unit circle: |L|^2 and the turn from -1, in radians.
function response(above, below, omega) {
  const [a, b] = valueAt(above, omega), [c, d] = valueAt(below, omega), size = c * c + d * d;
  const [x, y] = [(a * c + b * d) / size, (b * c - a * d) / size];
  return { square: x * x + y * y, turn: Math.atan2(-y, -x), real: x, imaginary: y };
}

// Crossovers lie where a sign changes; a resonance is narrow, so there are points about every pole.
function frequencies(...lists) {
  const points = Array.from({ length: GRID + 1 }, (_, i) => Math.PI * i / GRID);
  for (const [x, y] of lists.flat()) {
    const angle = Math.atan2(Math.abs(y), x), width = Math.max(1e-9, Math.abs(1 - Math.hypot(x, y)));
    for (const part of AROUND) points.push(angle + part * width);
  }
  return Float64Array.from(points.filter(w => w >= 0 && w <= Math.PI)).sort();
}

function zerosOf(f, points) {
  const found = [];
  let before = f(points[0]);
  for (let i = 1; i < points.length; i += 1) {
    const after = f(points[i]);
    if (Number.isFinite(before * after) && before * after < 0) {
      let [low, high, sign] = [points[i - 1], points[i], before];
      for (let round = 0; round < 60 && high > low; round += 1) {
        const middle = (low + high) / 2, value = f(middle);
        if (value * sign > 0) low = middle;
        else high = middle;
      }
      found.push((low + high) / 2);
    }
    before = after;
  }
  return found;
}

// {down, up, phase in degrees} of a stable loop: factors of the gain, Infinity and 0 where there are none.
export function marginsAt(found, k) {
  const { plan } = found, [D_c, N_c] = compensatorAt(found, k);
  const below = convolved(plan.den, D_c), above = convolved(plan.num, N_c).map(a => plan.servo ? a : -a);
  const closed = rootsOf(summed(below, above));
  if (closed.some(pole => !(modulus(pole) < 1))) return null;
  const points = frequencies(closed, plan.poles, rootsOf(D_c));
  const at = omega => response(above, below, omega);
  const turns = zerosOf(omega => at(omega).square - 1, points).map(w => Math.abs(at(w).turn));
  const inside = points.subarray(points[0] === 0 ? 1 : 0);
  const real = [0, Math.PI, ...zerosOf(omega => at(omega).imaginary, inside)].map(w => at(w));
  const factors = real.filter(value => value.real < 0 && Math.abs(value.imaginary) < 1e-4 * (Math.abs(value.real) + 1e-9))
    .map(value => -1 / value.real).filter(Number.isFinite);
  return {
    up: Math.min(Infinity, ...factors.filter(f => f > 1)),
    down: Math.max(0, ...factors.filter(f => f < 1)),
    phase: turns.length ? 180 / Math.PI * Math.min(...turns) : Infinity,
  };
}

// The poles of a loop whose intercalated transfer function is the target model: those asked for, the zeros of
// the plant that RCAC is not told, and the rest at 0, (4.18) and (4.39). None where RCAC is told what is wrong.
export function predicted(plan) {
  const { dials } = plan, told = withConjugates(dials.told), rest = [...plan.zeros];
  if (!isExact(dials)) return null;
  for (const zero of told) {
    const near = rest.findIndex(one => Math.hypot(one[0] - zero[0], one[1] - zero[1]) < SAME * modulus(zero));
    if (near < 0) return null;
    rest.splice(near, 1);
  }
  const asked = withConjugates(dials.poles), atZero = plan.n + dials.n_c - asked.length - rest.length;
  if (atZero < 0) return null;
  return [...asked, ...rest, ...Array.from({ length: atZero }, () => [0, 0])];
}
