// Polynomials of numbers, highest power first, and their roots [re, im].
export const convolved = (p, q) => {
  const product = new Array(p.length + q.length - 1).fill(0);
  p.forEach((a, i) => q.forEach((b, j) => { product[i + j] += a * b; }));
  return product;
};
export const summed = (p, q, sign = 1) => {
  const n = Math.max(p.length, q.length), at = (r, i) => r[i - n + r.length] ?? 0;
  return Array.from({ length: n }, (_, i) => at(p, i) + sign * at(q, i));
};
export const modulus = ([x, y]) => Math.hypot(x, y);

// By Aberth and Ehrlich, all at once; what is zero at the end is a root at 0. From `start` where there is one.
export function rootsOf(polynomial, start = null) {
  const largest = Math.max(...polynomial.map(Math.abs));
  let p = polynomial.slice(polynomial.findIndex(a => a !== 0)), atZero = 0;
  if (!Number.isFinite(largest) || largest === 0) return [];
  while (p.length > 1 && Math.abs(p.at(-1)) <= 1e-15 * largest) { p = p.slice(0, -1); atZero += 1; }
  p = p.map(a => a / p[0]);
  const n = p.length - 1, x = new Float64Array(n), y = new Float64Array(n);
  const near = start?.length === n + atZero ? [...start].sort((a, b) => modulus(b) - modulus(a)) : null;
  const radius = Math.max(...p.slice(1).map((a, i) => Math.abs(a) ** (1 / (i + 1))), 1e-3);
  for (let i = 0; i < n; i += 1) {
    const angle = 2 * Math.PI * i / n + 0.4, size = 0.9 * radius * (1 - 0.3 * i / n);
    [x[i], y[i]] = near ? [near[i][0] + 1e-9 * (i + 1), near[i][1] + (i % 2 ? 1e-9 : -1e-9)]
      : [size * Math.cos(angle), size * Math.sin(angle)];
  }
  for (let round = 0; round < 150; round += 1) {
    let moved = 0;
    for (let i = 0; i < n; i += 1) {
      const [a, b] = [x[i], y[i]];
      let [vr, vi, dr, di] = [1, 0, 0, 0];  // the value and the derivative
      for (let k = 1; k <= n; k += 1) {
        [dr, di] = [dr * a - di * b + vr, dr * b + di * a + vi];
        [vr, vi] = [vr * a - vi * b + p[k], vr * b + vi * a];
      }
      const size = vr * vr + vi * vi;
      if (size === 0) continue;
      let [qr, qi] = [(dr * vr + di * vi) / size, (di * vr - dr * vi) / size];
      for (let j = 0; j < n; j += 1) {
        if (j === i) continue;
        const [ex, ey] = [a - x[j], b - y[j]], far = ex * ex + ey * ey || 1e-300;
        qr -= ex / far;
        qi += ey / far;
      }
      const whole = qr * qr + qi * qi || 1e-300, [sx, sy] = [qr / whole, -qi / whole];
      if (!Number.isFinite(sx + sy)) continue;
      x[i] -= sx;
      y[i] -= sy;
      moved = Math.max(moved, Math.hypot(sx, sy) / (Math.hypot(a, b) + 1e-3));
    }
    if (moved < 1e-13) break;
  }
  const found = Array.from(x, (a, i) => [a, Math.abs(y[i]) < 1e-10 * (Math.abs(a) + 1e-3) ? 0 : y[i]]);
  return [...found, ...Array.from({ length: atZero }, () => [0, 0])];
}

// The whole list of roots of which only those with im >= 0 are given.
export const withConjugates = roots => roots.flatMap(([x, y]) => y ? [[x, y], [x, -y]] : [[x, 0]]);

// For each of `wanted` how far its partner in `found` is, and which one it is; the nearest pairs first.
function paired(wanted, found) {
  const pairs = wanted.flatMap((a, i) => found.map((b, j) => [Math.hypot(a[0] - b[0], a[1] - b[1]), i, j]));
  const partners = wanted.map(() => [Infinity, -1]), used = new Set();
  for (const [distance, i, j] of pairs.sort((a, b) => a[0] - b[0])) {
    if (partners[i][0] < Infinity || used.has(j)) continue;
    partners[i] = [distance, j];
    used.add(j);
  }
  return partners;
}
export const distances = (wanted, found) => paired(wanted, found).map(([distance]) => distance);

// The largest relative change, on the unit circle, of the polynomial with the roots `found` that gives
// it the wanted ones; its other roots stay. A multiple root is far from its copies where this is small.
export function backwardError(wanted, found) {
  const partners = paired(wanted, found), asked = [...found];
  if (partners.some(([distance]) => distance === Infinity)) return Infinity;
  partners.forEach(([, j], i) => { asked[j] = wanted[i]; });
  const angles = Array.from({ length: 400 }, (_, k) => Math.PI * (k + 0.5) / 400);
  for (const [x, y] of [...asked, ...found]) angles.push(Math.abs(Math.atan2(y, x)));
  const value = (roots, c, s) => roots.reduce(([a, b], [x, y]) =>
    [a * (c - x) - b * (s - y), a * (s - y) + b * (c - x)], [1, 0]);
  return Math.max(...angles.map(angle => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)], p = value(asked, c, s), r = value(found, c, s);
    const largest = Math.max(modulus(p), modulus(r));
    return largest ? Math.hypot(p[0] - r[0], p[1] - r[1]) / largest : 0;
  }));
}
