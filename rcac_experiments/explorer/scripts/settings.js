// The dials as an experiment file, which `rcac verify` runs.
import { inDecimals, inWords, written } from "./rationals.js";
import { exactPlant, isServo, modelling, planOf } from "./plan.js";

const quoted = text => JSON.stringify(text).replaceAll("\u007f", "\\u007f");
const real = text => /^[+-]?\d+$/.test(text) ? `${text}.0` : text;
export const value = v => Array.isArray(v) ? `[${v.map(value).join(", ")}]`
  : typeof v === "object" ? `{ ${Object.entries(v).map(([key, part]) => `${/^[\w-]+$/.test(key) ? key : quoted(key)} = ${value(part)}`).join(", ")} }`
    : typeof v === "string" ? quoted(v) : String(v);
const complex = roots => `[${roots.flatMap(([x, y]) => y
  ? [`"${inDecimals(x)}+${inDecimals(y)}j"`, `"${inDecimals(x)}-${inDecimals(y)}j"`] : [`"${inDecimals(x)}"`]).join(", ")}]`;

function signals(dials) {
  if (dials.signal === "file") return Object.entries(dials.signals).map(([key, part]) => `${key} = ${value(part)}`);
  const step = `{ step = ${real(dials.amplitude)} }`, noise = `{ white_noise = ${real(dials.noise)} }`;
  if (dials.signal === "command") return [`r = ${step}`, ...Number(dials.noise) ? [`d = ${noise}`] : []];
  const base = dials.signal === "step" ? step
    : dials.signal === "wave" ? `{ harmonic = 0.3, amplitude = ${real(dials.amplitude)}, phase = -1.5707963267948966 }` : "{ step = 0.0 }";
  return [`w = ${Number(dials.noise) ? `{ sum = [${base}, ${noise}] }` : base}`];
}

function bounds({ ellipsoid: { center, factor } }) {
  const list = values => `[${Array.from(values, String).join(", ")}]`, n = center.length;
  const rows = Array.from(center, (_, i) => list(factor.slice(i * n, (i + 1) * n)));
  return `bounds = { center = ${list(center)}, factor = [${rows.join(", ")}] }`;
}

export function asToml(dials, room, lost) {
  const [numerator, denominator] = exactPlant(dials), { H, d_zu } = modelling(dials), plan = planOf(dials, room);
  return `id = "explorer"
title = ${quoted(dials.title)}

[plant]
problem = "${isServo(dials) ? "servo" : "standard"}"
G = "(${inWords(numerator)})/(${inWords(denominator)})"

[signals]
${signals(dials).join("\n")}

[target]
model = "pole placement"
d_zu = ${d_zu}
H = "${written(H)}"
nmp_zeros = ${complex(dials.told)}
poles = ${complex(dials.poles)}

[controller]
structure = "iir"
n_c = ${dials.n_c}
k_w = ${plan.k_w}
R_theta = ${real(dials.R_theta)}
lambda = ${real(dials.lambda)}
${plan.theta_0.some(Boolean) ? `theta_0 = [${plan.theta_0.map(String).join(", ")}]\n` : ""}${plan.isKept ? `${bounds(plan)}\n` : ""}${dials.bound === "none" ? "" : `
[saturation]
low = ${real(`-${dials.bound}`)}
high = ${real(dials.bound)}
`}
[run]
steps = ${dials.steps}${dials.seed ? `\nseed = ${dials.seed}` : ""}${lost ? '\nexpected = "diverged"' : ""}
`;
}
