// The z-plane: the loop's poles on a canvas, rings and triangles that are dragged above it.
import { drawing } from "./charts.js";
import { modulus } from "./roots.js";
import { shown } from "./words.js";

const SVG = "http://www.w3.org/2000/svg";
const WIDE = 440, HIGH = 400;  // of the picture's own coordinates
const LARGEST_POLE = 0.98, SMALLEST_ZERO = 1, LARGEST_ZERO = 6, LEAST = 0.02;

export class Plane {
  constructor(canvas, handles, moved) {
    [this.canvas, this.handles, this.moved] = [canvas, handles, moved];
    this.selected = null;
    this.shape = "";
    handles.setAttribute("viewBox", `0 0 ${WIDE} ${HIGH}`);
    handles.addEventListener("pointerdown", event => this.take(event));
    handles.addEventListener("pointermove", event => this.drag(event));
    // What lies in an SVG has no touch-action of its own everywhere: a finger on a ring would pan the page.
    handles.addEventListener("touchstart", event => {
      if (event.target.closest(".handle")) event.preventDefault();
    }, { passive: false });
    for (const end of ["pointerup", "pointercancel"]) handles.addEventListener(end, () => { this.held = null; });
    handles.addEventListener("keydown", event => this.press(event));
    handles.addEventListener("focusin", event => {
      const handle = event.target.closest(".handle");
      if (handle) this.selected = { kind: handle.dataset.kind, index: Number(handle.dataset.index) };
    });
  }

  // So that the unit circle and the plant's zeros and poles are seen, as far as 2.4.
  fit(points) {
    const xs = points.map(([x]) => x).filter(x => Math.abs(x) < 2.4);
    const right = Math.max(1.2, ...xs.map(x => x + 0.18)), left = Math.min(-1.2, ...xs.map(x => x - 0.18));
    this.scale = Math.min(WIDE / (right - left), HIGH / 2.36);
    this.x_0 = (WIDE - this.scale * (right + left)) / 2;
    this.y_0 = HIGH / 2;
  }

  at([x, y]) { return [this.x_0 + this.scale * x, this.y_0 - this.scale * y]; }

  // Where it is drawn, and its modulus where that is outside the picture.
  rim(point) {
    const [x, y] = this.at(point);
    if (x > 10 && x < WIDE - 10 && y > 10 && y < HIGH - 10) return [[x, y], 0];
    const [dx, dy] = [x - this.x_0, y - this.y_0];
    const part = Math.min(dx > 0 ? (WIDE - 14 - this.x_0) / dx : dx < 0 ? (14 - this.x_0) / dx : Infinity,
      dy ? (this.y_0 - 14) / Math.abs(dy) : Infinity);
    return [[this.x_0 + part * dx, this.y_0 + part * dy], modulus(point)];
  }

  draw({ dials, plan, poles, trail, theory }, colour) {
    const { pen, width } = drawing(this.canvas), turn = 2 * Math.PI, [o_x, o_y] = this.at([0, 0]);
    pen.scale(width / WIDE, width / WIDE);
    pen.fillStyle = colour.shade;
    pen.beginPath();
    pen.arc(o_x, o_y, this.scale, 0, turn);
    pen.fill();
    pen.strokeStyle = colour.line;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(0, o_y);
    pen.lineTo(WIDE, o_y);
    pen.moveTo(o_x, 0);
    pen.lineTo(o_x, HIGH);
    pen.stroke();
    pen.strokeStyle = colour.quiet;
    pen.lineWidth = 1.3;
    pen.beginPath();
    pen.arc(o_x, o_y, this.scale, 0, turn);
    pen.stroke();
    pen.fillStyle = colour.quiet;
    pen.fillText("1", o_x + this.scale + 4, o_y + 15);
    pen.fillText("j", o_x + 5, o_y - this.scale - 5);
    pen.fillStyle = colour.c1;
    trail.forEach((points, i) => {
      pen.globalAlpha = 0.1 + 0.4 * i / trail.length;
      for (const point of points) {
        const [[x, y], far] = this.rim(point);
        if (!far) pen.fillRect(x - 1.5, y - 1.5, 3, 3);
      }
    });
    pen.globalAlpha = 1;
    for (const pole of plan.poles) this.cross(pen, pole, colour.quiet, 1.6, 4.5);
    pen.strokeStyle = colour.quiet;
    for (const zero of plan.zeros) {
      const [[x, y]] = this.rim(zero);
      pen.lineWidth = 1.6;
      pen.beginPath();
      pen.arc(x, y, 5, 0, turn);
      pen.stroke();
    }
    pen.strokeStyle = colour.good;
    for (const place of theory) {
      const [[x, y]] = this.rim(place);
      pen.lineWidth = 1.6;
      pen.beginPath();
      [[0, -8], [8, 0], [0, 8], [-8, 0]].forEach(([dx, dy], i) => pen[i ? "lineTo" : "moveTo"](x + dx, y + dy));
      pen.closePath();
      pen.stroke();
    }
    for (const pole of poles) this.cross(pen, pole, modulus(pole) >= 1 ? colour.bad : colour.c1, 2.6, 5.5);
    this.place(dials);
  }

  cross(pen, point, colour, thick, size) {
    const [[x, y], far] = this.rim(point);
    if (!Number.isFinite(x + y)) return;
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = thick;
    pen.lineCap = "round";
    pen.beginPath();
    pen.moveTo(x - size, y - size);
    pen.lineTo(x + size, y + size);
    pen.moveTo(x - size, y + size);
    pen.lineTo(x + size, y - size);
    pen.stroke();
    if (!far) return;
    pen.textAlign = x > WIDE - 60 ? "right" : x < 60 ? "left" : "center";
    pen.fillText(far < 100 ? far.toFixed(1) : far.toExponential(0), x, y < 30 ? y + 20 : y - 10);
    pen.textAlign = "left";
  }

  // One handle for each ring and triangle; the lower one of a pair is a copy without focus.
  place(dials) {
    const wanted = ["poles", "told"].flatMap(kind => dials[kind].flatMap(([, y], index) =>
      (y ? [1, -1] : [1]).map(side => ({ kind, index, side }))));
    const shape = JSON.stringify(wanted);
    if (shape !== this.shape) {
      this.shape = shape;
      const kept = document.activeElement?.closest?.(".handle")?.dataset;
      const again = kept ? `[data-kind="${kept.kind}"][data-index="${kept.index}"][tabindex]` : null;
      this.handles.replaceChildren(...wanted.map(one => this.handle(one)));
      if (again) this.handles.querySelector(again)?.focus();
    }
    for (const handle of this.handles.children) {
      const { kind, index, side } = handle.dataset, [x, y] = dials[kind][index];
      const [[px, py]] = this.rim([x, y * side]);
      handle.setAttribute("transform", `translate(${px.toFixed(1)} ${py.toFixed(1)})`);
      if (side !== "1") continue;
      handle.setAttribute("aria-valuenow", x.toFixed(3));
      handle.setAttribute("aria-valuetext", shown([x, y]));
    }
  }

  handle({ kind, index, side }) {
    const group = document.createElementNS(SVG, "g"), [of, name] = kind === "poles"
      ? [["circle", { r: 10 }], "requested pole"] : [["path", { d: "M0 -12L11 8H-11Z" }], "zero that RCAC knows"];
    group.setAttribute("class", "handle");
    Object.assign(group.dataset, { kind, index, side });
    if (side === 1) {
      const facts = {
        tabindex: 0, role: "slider", "aria-label": `${name}, ${index + 1}`,
        "aria-valuemin": kind === "poles" ? -LARGEST_POLE : -LARGEST_ZERO,
        "aria-valuemax": kind === "poles" ? LARGEST_POLE : LARGEST_ZERO,
      };
      for (const [key, value] of Object.entries(facts)) group.setAttribute(key, value);
    } else group.setAttribute("aria-hidden", "true");
    for (const [tag, facts] of [["circle", { r: 28, class: "area" }], of]) {
      const part = document.createElementNS(SVG, tag);
      for (const [key, value] of Object.entries(facts)) part.setAttribute(key, value);
      if (!facts.class) part.setAttribute("class", "ring");
      group.append(part);
    }
    return group;
  }

  pointOf(event) {
    const box = this.handles.getBoundingClientRect(), unit = box.width / WIDE;
    return [((event.clientX - box.left) / unit - this.x_0) / this.scale, (this.y_0 - (event.clientY - box.top) / unit) / this.scale];
  }

  // The nearest handle, where several areas lie on one another.
  take(event) {
    if (!event.target.closest(".handle")) return;
    const unit = this.handles.getBoundingClientRect().width / WIDE, box = this.handles.getBoundingClientRect();
    const [px, py] = [(event.clientX - box.left) / unit, (event.clientY - box.top) / unit];
    let best = null, least = Infinity;
    for (const handle of this.handles.children) {
      const [x, y] = handle.getAttribute("transform").match(/-?[\d.]+/g).map(Number);
      const far = Math.hypot(x - px, y - py);
      if (far < least) [best, least] = [handle, far];
    }
    this.held = { kind: best.dataset.kind, index: Number(best.dataset.index), side: Number(best.dataset.side) };
    this.handles.setPointerCapture(event.pointerId);
    this.handles.querySelector(`[data-kind="${this.held.kind}"][data-index="${this.held.index}"][tabindex]`)?.focus({ preventScroll: true });
    event.preventDefault();
  }

  drag(event) {
    if (!this.held) return;
    const [x, y] = this.pointOf(event);
    this.moved(this.held.kind, this.held.index, [x, y * this.held.side]);
  }

  press(event) {
    const handle = event.target.closest?.(".handle");
    if (!handle) return;
    const far = event.shiftKey ? 0.1 : 0.01;
    const by = { ArrowLeft: [-far, 0], ArrowRight: [far, 0], ArrowUp: [0, far], ArrowDown: [0, -far] }[event.key];
    if (!by) return;
    event.preventDefault();
    this.moved(handle.dataset.kind, Number(handle.dataset.index), null, by);
  }
}

// Where a ring may be: inside the circle, a zero that RCAC knows on or outside it; a pair stays one.
export function allowed(kind, [x, y], isPair) {
  y = isPair ? Math.max(LEAST, y) : 0;
  const size = Math.hypot(x, y), three = v => Number(v.toFixed(3));
  if (kind === "poles" && size > LARGEST_POLE) [x, y] = [x * LARGEST_POLE / size, y * LARGEST_POLE / size];
  if (kind === "told") {
    const wanted = Math.min(LARGEST_ZERO, Math.max(SMALLEST_ZERO + 0.001, size));
    [x, y] = size ? [x * wanted / size, y * wanted / size] : [wanted, 0];
  }
  return [three(x), isPair ? Math.max(LEAST, three(y)) : 0];
}
