// A transfer function in q or z as it is typed: numbers, + - * / ^ ** and parentheses.
import { ONE, ZERO, add, areCoprime, exactly, minus, multiply, over, scaled, trimmed } from "./rationals.js";

const LARGEST_POWER = 12;

export function transferFunction(text) {
  const plain = text.replace(/\*\*/g, "^").replace(/\s+/g, "").replaceAll("−", "-");
  const words = plain.match(/\d+\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?|[qz]|[-+*/^()]/gi) ?? [];
  if (words.join("") !== plain) throw new Error("Only numbers, q, + - * / ^ and parentheses are read here.");
  let next = 0;
  const of = p => [p, [ONE]];
  const product = ([a, b], [c, d]) => [multiply(a, c), multiply(b, d)];
  const sum = () => {
    const sign = words[next] === "-" ? (next += 1, -1) : (next += words[next] === "+" ? 1 : 0, 1);
    let [n, d] = term();
    if (sign < 0) n = n.map(minus);
    while (words[next] === "+" || words[next] === "-") {
      const factor = words[next++] === "-" ? minus(ONE) : ONE, [m, e] = term();
      [n, d] = [add(multiply(n, e), multiply(m, d), factor), multiply(d, e)];
    }
    return [n, d];
  };
  const term = () => {
    let value = power();
    for (;;) {
      if (words[next] === "*") { next += 1; value = product(value, power()); }
      else if (words[next] === "/") { next += 1; const [a, b] = power(); value = product(value, [b, a]); }
      else if (/^[(qz]$/i.test(words[next] ?? "")) value = product(value, power());
      else return value;
    }
  };
  const power = () => {
    const base = atom();
    if (words[next] !== "^") return base;
    const exponent = Number(words[next + 1]);
    next += 2;
    if (!(Number.isInteger(exponent) && exponent >= 0 && exponent <= LARGEST_POWER))
      throw new Error(`A power must be a whole number up to ${LARGEST_POWER}.`);
    let value = of([ONE]);
    for (let i = 0; i < exponent; i += 1) value = product(value, base);
    return value;
  };
  const atom = () => {
    const word = words[next++];
    if (word === "(") {
      const value = sum();
      if (words[next++] !== ")") throw new Error("A parenthesis is not closed.");
      return value;
    }
    if (/^[qz]$/i.test(word ?? "")) return of([ONE, ZERO]);
    if (/^[\d.]/.test(word ?? "")) return of([exactly(word)]);
    throw new Error(`Something is missing after “${words.slice(0, next - 1).join("")}”.`);
  };
  let [n, d] = sum();
  if (next < words.length) throw new Error(`“${words.slice(next).join("")}” cannot be read.`);
  [n, d] = [trimmed(n), trimmed(d)];
  if (d[0][0] === 0n) throw new Error("The denominator is zero.");
  if (n[0][0] === 0n) throw new Error("G = 0: the control does not act on z.");
  const monic = over(ONE, d[0]);
  [n, d] = [scaled(n, monic), scaled(d, monic)];
  if (n.length >= d.length) throw new Error("G must be strictly proper: its numerator’s degree below its denominator’s.");
  if (d.length > LARGEST_POWER + 1) throw new Error(`Orders up to ${LARGEST_POWER}.`);
  if (!areCoprime(n, d)) throw new Error("Numerator and denominator share a factor: no controller moves that pole. Cancel it.");
  return [n, d];
}
