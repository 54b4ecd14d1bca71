// Rational numbers [numerator, denominator > 0] of BigInt, and polynomials of them, highest power first.
const divisor = (a, b) => {
  a = a < 0n ? -a : a;
  while (b) [a, b] = [b < 0n ? -b : b, a % b];
  return a || 1n;
};
export const rational = (n, d = 1n) => {
  if (d < 0n) [n, d] = [-n, -d];
  const g = divisor(n, d);
  return [n / g, d / g];
};
export const ZERO = [0n, 1n], ONE = [1n, 1n];
export const plus = (a, b) => rational(a[0] * b[1] + b[0] * a[1], a[1] * b[1]);
export const times = (a, b) => rational(a[0] * b[0], a[1] * b[1]);
export const minus = a => [-a[0], a[1]];
export const over = (a, b) => rational(a[0] * b[1], a[1] * b[0]);
const isZero = a => a[0] === 0n;

// "1.04", "-2", "1e-6" and "5/3" as they stand.
export function exactly(text) {
  const found = /^\s*([+-]?)(\d*)\.?(\d*)(?:e([+-]?\d{1,4}))?(?:\/(\d+))?\s*$/i.exec(text);
  if (!found || !(found[2] + found[3])) throw new Error(`“${text}” is no number.`);
  const [, sign, whole, part, power = "0", below = "1"] = found;
  const digits = BigInt(whole + part) * (sign === "-" ? -1n : 1n), shift = Number(power) - part.length;
  if (BigInt(below) === 0n) throw new Error(`“${text}” divides by zero.`);
  const ten = 10n ** BigInt(Math.abs(shift));
  return shift < 0 ? rational(digits, ten * BigInt(below)) : rational(digits * ten, BigInt(below));
}

// Rounded once to float64: 64 bits of the quotient, the last of which says whether there is more.
export function rounded([n, d]) {
  if (n === 0n) return 0;
  const size = n < 0n ? -n : n, bits = x => x.toString(2).length;
  const shift = 64 - bits(size) + bits(d);
  const a = shift > 0 ? size << BigInt(shift) : size, b = shift < 0 ? d << BigInt(-shift) : d;
  const value = Number(a / b | (a % b ? 1n : 0n)), half = Math.trunc(shift / 2);
  return (n < 0n ? -1 : 1) * value * 2 ** -half * 2 ** (half - shift);
}

// As a decimal where it has an end, else as a fraction.
export function written([n, d]) {
  let rest = d, places = 0;
  for (const prime of [2n, 5n]) {
    let count = 0;
    while (rest % prime === 0n) { rest /= prime; count += 1; }
    places = Math.max(places, count);
  }
  if (rest !== 1n || places > 40) return `${n}/${d}`;
  const digits = (n < 0n ? -n : n) * 10n ** BigInt(places) / d, text = digits.toString().padStart(places + 1, "0");
  const point = text.length - places;
  return `${n < 0n ? "-" : ""}${text.slice(0, point)}${places ? `.${text.slice(point)}` : ""}`;
}

export const multiply = (p, q) => {
  const product = Array.from({ length: p.length + q.length - 1 }, () => ZERO);
  p.forEach((a, i) => q.forEach((b, j) => { product[i + j] = plus(product[i + j], times(a, b)); }));
  return product;
};
export const add = (p, q, sign = ONE) => {
  const n = Math.max(p.length, q.length), at = (r, i) => r[i - n + r.length] ?? ZERO;
  return Array.from({ length: n }, (_, i) => plus(at(p, i), times(sign, at(q, i))));
};
export const trimmed = p => {
  const first = p.findIndex(a => !isZero(a));
  return first < 0 ? [ZERO] : p.slice(first);
};
export const scaled = (p, a) => p.map(b => times(a, b));
export const shifted = (p, n) => [...p, ...Array.from({ length: n }, () => ZERO)];

const remainder = (p, q) => {
  p = trimmed(p);
  while (p.length >= q.length && !isZero(p[0])) {
    const factor = over(p[0], q[0]);
    p = trimmed(p.map((a, i) => i < q.length ? plus(a, minus(times(factor, q[i]))) : a).slice(1));
  }
  return p;
};
export function areCoprime(p, q) {
  p = trimmed(p);
  q = trimmed(q);
  while (!(q.length === 1 && isZero(q[0]))) [p, q] = [q, remainder(p, q)];
  return p.length === 1;
}

// The monic polynomial with these roots [re, im], of a pair the one with im > 0; each as its decimal.
export const DIGITS = 12;
export const inDecimals = x => (Object.is(x, -0) ? 0 : x).toFixed(DIGITS).replace(/\.?0+$/, "");
export const withRoots = roots => roots.reduce((product, [re, im]) => {
  const a = exactly(inDecimals(re)), b = exactly(inDecimals(im));
  if (isZero(b)) return multiply(product, [ONE, minus(a)]);
  return multiply(product, [ONE, times([-2n, 1n], a), plus(times(a, a), times(b, b))]);
}, [ONE]);

// A polynomial in q as a Python program reads it.
export const inWords = p => p.map((a, i) => {
  const power = p.length - 1 - i, size = a[0] < 0n ? minus(a) : a;
  if (isZero(a)) return "";
  const q = power > 1 ? `q**${power}` : power ? "q" : "";
  const factor = written(size) === "1" && power ? q : `${written(size)}${power ? `*${q}` : ""}`;
  return `${a[0] < 0n ? " - " : " + "}${factor}`;
}).join("").replace(/^ \+ /, "").replace(/^ - /, "-") || "0";
