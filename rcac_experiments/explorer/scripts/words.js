// The result of the run in one sentence, and what RCAC knows of the plant.
import { backwardError, distances, modulus, withConjugates } from "./roots.js";
import { polesAt } from "./loop.js";
import { modelling } from "./plan.js";
import { written } from "./rationals.js";

// As ExactComparison.is_reached decides: the backward error up to which poles are reached, and a
// distance that is none, whatever the conditioning of the roots.
const REACHED = 0.05, NEAR = 0.01;
const NEAR_CIRCLE = 1e-9;

export const shown = ([x, y]) => `${text(x)}${y ? ` ± ${text(Math.abs(y))}j` : ""}`;
const text = x => Number(x.toFixed(Math.abs(x) < 10 ? 3 : 1)).toString().replace("-", "−");
const raised = digits => [...digits].map(c => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]).join("");
const small = x => x < 1e-3 ? x.toExponential(0).replace(/e-(\d+)/, (_, digits) => `·10⁻${raised(digits)}`)
  : Number(x.toPrecision(2)).toString();

// "lost", "unstable", "still" (nothing acts, nothing is learnt), "stable" or "reached".
export function outcomeOf(found) {
  const wanted = withConjugates(found.plan.dials.poles);
  if (found.lost) return { kind: "lost", poles: polesAt(found, found.done), wanted, far: [] };
  const poles = polesAt(found, found.done), far = distances(wanted, poles), worst = Math.max(0, ...far);
  if (found.w.every(value => value === 0)) return { kind: "still", poles, wanted, far, worst };
  const largest = Math.max(...poles.map(modulus));
  const isReached = worst <= NEAR || backwardError(wanted, poles) <= REACHED;
  const kind = largest >= 1 - NEAR_CIRCLE ? "unstable" : isReached ? "reached" : "stable";
  return { kind, poles, wanted, far, worst, largest };
}

// The first step after which |z| stays below a twentieth of its peak since RCAC began.
function settled({ z, plan }) {
  let peak = 0, tail = 0, last = plan.k_w;
  for (let k = plan.k_w; k < z.length; k += 1) peak = Math.max(peak, Math.abs(z[k]));
  for (let k = Math.floor(0.9 * z.length); k < z.length; k += 1) tail = Math.max(tail, Math.abs(z[k]));
  if (tail > 0.2 * peak) return null;
  for (let k = plan.k_w; k < z.length; k += 1) if (Math.abs(z[k]) > Math.max(1.5 * tail, 0.05 * peak)) last = k + 1;
  return last - plan.k_w;
}

const late = ({ z }) => z.subarray(Math.floor(z.length / 2)).reduce((most, value) => Math.max(most, Math.abs(value)), 0);

// Parts [words, class]; the page makes elements of them, so that nothing is read as HTML.
export function sentence(found, outcome) {
  const { plan } = found, { dials } = plan, count = outcome.wanted.length;
  const untold = plan.zeros.filter(zero => modulus(zero) >= 1 && !withConjugates(dials.told)
    .some(known => Math.hypot(known[0] - zero[0], known[1] - zero[1]) < 0.05 * modulus(zero)));
  if (outcome.kind === "still") return [["No input excites the loop, so RCAC cannot learn. "], ["Choose a signal or noise.", "quiet"]];
  if (outcome.kind === "lost") {
    const middle = polesAt(found, Math.floor(0.6 * found.done));
    const cancelled = untold.find(zero => middle.some(pole => Math.hypot(pole[0] - zero[0], pole[1] - zero[1]) < 0.02 * modulus(zero)));
    const why = cancelled ? `RCAC cancels the unknown nonminimum-phase zero ${shown(cancelled)}, and u diverges.`
      : untold.length ? `RCAC does not know the nonminimum-phase zero ${shown(untold[0])} of the plant.`
        : Number(dials.gain) < 0 ? "RCAC assumes the wrong sign of the gain."
          : "The requested poles are too fast for this plant, or an assumption of RCAC is wrong.";
    return [[`Diverged at step ${found.done}. `, "bad"], [why]];
  }
  if (outcome.kind === "unstable") return [["Unstable: ", "bad"], [`the loop with the final theta has a pole of modulus ${text(outcome.largest)}. Use more steps, or another R_theta.`]];
  const steps = settled(found);
  const calm = steps === null ? `|z| stays below ${small(late(found))}` : `z settles ${steps} steps after RCAC starts`;
  const what = plan.poles.some(pole => modulus(pole) > 1) ? "An unstable plant, stabilised: " : "Stable: ";
  if (outcome.kind === "reached") return [[what], [calm, "good"], [", and "],
    [count === 1 ? "the requested pole is reached" : `all ${count} requested poles are reached`, "good"], [`; largest distance ${small(outcome.worst)}.`]];
  const missed = outcome.far.filter(distance => distance > NEAR).length;
  const worst = outcome.wanted[outcome.far.indexOf(outcome.worst)];
  if (!Number.isFinite(outcome.worst)) return [[what], [calm, "good"], [`, but the loop has ${outcome.poles.length} poles for ${count} requested ones: `], ["raise n_c.", "warning"]];
  const few = 2 * dials.n_c < count ? ` n_c = ${dials.n_c} has ${2 * dials.n_c} coefficients for ${count} poles.` : "";
  const which = count === 1 ? "the requested pole is missed"
    : missed === count ? `all ${count} requested poles are missed` : `${missed} of ${count} requested poles ${missed === 1 ? "is" : "are"} missed`;
  return [[what], [calm, "good"], [", but "], [which, "warning"], [`, ${shown(worst)} by ${small(outcome.worst)}.${few}`]];
}

// Margins, poles predicted by theory, and share of steps with u at its limit.
export function besides(found, poles, margins, predicted) {
  const { plan } = found, parts = [];
  const factor = x => x === Infinity ? "∞" : Number(x.toPrecision(3)).toString();
  if (margins) parts.push(`Margins: the gain may change by ${factor(margins.down)} to ${factor(margins.up)}, the phase by `
    + `${margins.phase === Infinity ? "any angle" : `${text(margins.phase)}°`}.`);
  else parts.push("Margins: none, since the loop is unstable.");
  if (predicted) {
    const worst = Math.max(...distances(predicted, poles));
    parts.push(`Theory predicts the poles of a loop that matches the target model: ${predicted.filter(([, y]) => y >= 0).map(shown).join(", ")};`
      + ` ${Number.isFinite(worst) ? `the poles of theta differ by at most ${small(worst)}.` : "theta has no poles."}`);
  } else parts.push("No loop matches the target model: an assumption of RCAC is wrong, or n_c is too small.");
  if (Number.isFinite(plan.bound)) {
    const learnt = found.u.subarray(plan.k_w), count = learnt.filter(value => Math.abs(value) > plan.bound).length;
    parts.push(`u is at its limit in ${Math.round(100 * count / Math.max(1, learnt.length))} % of the steps.`);
  }
  return parts.join(" ");
}

// How much of the certified set theta uses, and where it is projected.
export function ofTheSet({ plan, projected, theta, l_theta, done }, shares) {
  const { dials } = plan, { ellipsoid } = dials, percent = x => `${Number((100 * x).toPrecision(x < 1 ? 2 : 3))} %`;
  if (!plan.ellipsoid) {
    if (ellipsoid.center) return "The set is that of the plant, the problem and the order of the scene; none is computed here.";
    return dials.n_c === dials.home.n_c && polesAt({ plan, theta, l_theta, done }, 0).some(pole => modulus(pole) >= 1 - NEAR_CIRCLE)
      ? "No set: theta(0) does not stabilise this plant." : "No set is known for this plant.";
  }
  const most = shares.reduce((a, b) => Math.max(a, b), 0), left = shares.findIndex(share => share > 1);
  const claim = ellipsoid.is_proved ? "In this set no motion of theta destabilises the loop. " : "The ellipsoid of the file has no proof on this plant. ";
  const limit = Number.isFinite(plan.bound) ? " The proof does not hold where u is at its limit." : "";
  if (!plan.isKept) return `${claim}${left < 0 ? `RCAC stays in it and uses ${percent(most)} of its radius.` : `RCAC leaves it at step ${left}.`}${limit}`;
  const count = projected.reduce((sum, one) => sum + one, 0);
  return `${claim}RCAC uses ${percent(most)} of its radius; theta is projected at ${count} step${count === 1 ? "" : "s"}`
    + `${count ? `, first at step ${projected.indexOf(1)}` : ""}.${limit}`;
}

export function known(plan) {
  const { H, d_zu } = modelling(plan.dials), { told } = plan.dials;
  const unstable = plan.poles.filter(pole => pole[1] >= 0).map(shown).join(", ");
  return `RCAC knows of the plant: its first coefficient ${Number(written(H)) ? text(Number(written(H))) : written(H)}, its relative degree ${d_zu}`
    + `${told.length ? ` and its zero${told.length > 1 ? "s" : ""} ${told.map(shown).join(", ")}` : ""}. It does not know the poles ${unstable}.`;
}
