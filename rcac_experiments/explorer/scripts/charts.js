// Lines over the steps on a canvas: grid, numbers, a mark where RCAC starts, the cursor.
const LEFT = 52, RIGHT = 10, TOP = 8;

// The colours of the style sheet as a canvas reads them; they change with the scheme.
export function colours(names) {
  const probe = document.createElement("i");
  document.body.append(probe);
  const found = {};
  for (const name of names) {
    probe.style.color = `var(--${name})`;
    found[name] = getComputedStyle(probe).color;
  }
  probe.remove();
  return found;
}

export function drawing(canvas) {
  const width = canvas.clientWidth, height = canvas.clientHeight, ratio = devicePixelRatio || 1;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  return { pen, width, height };
}

const tidy = x => {
  const power = 10 ** Math.floor(Math.log10(x)), part = x / power;
  return (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10) * power;
};
const label = (v, step) => {
  if (Math.abs(v) < step / 2) return "0";
  const size = Math.abs(v);
  return (size >= 1e4 || size < 1e-3 ? v.toExponential(0).replace("e+", "e") : String(Number(v.toPrecision(3)))).replaceAll("-", "−");
};

export const stepAt = (canvas, x, steps) => {
  const box = canvas.getBoundingClientRect(), part = (x - box.left - LEFT) / (box.width - LEFT - RIGHT);
  return Math.round(Math.min(1, Math.max(0, part)) * (steps - 1));
};

// `series`: { values, count, stride, first, colour, thick }.
export function lines(canvas, series, { low, high, steps, colour, start, cursor, axis, end, marks = null }) {
  const { pen, width, height } = drawing(canvas);
  const [x_0, x_1, y_0, y_1] = [LEFT, width - RIGHT, TOP, height - (axis ? 22 : TOP)];
  const X = k => x_0 + (x_1 - x_0) * k / Math.max(1, steps - 1);
  const Y = v => y_1 - (y_1 - y_0) * (v - low) / (high - low);
  pen.lineWidth = 1;
  pen.fillStyle = colour.quiet;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  const apart = tidy((high - low) / Math.max(2, (y_1 - y_0) / 40));
  for (let i = Math.ceil(low / apart); i * apart <= high; i += 1) {
    const v = i * apart;
    pen.strokeStyle = i === 0 ? colour.quiet : colour.line;
    pen.globalAlpha = i === 0 ? 0.8 : 0.6;
    pen.beginPath();
    pen.moveTo(x_0, Y(v));
    pen.lineTo(x_1, Y(v));
    pen.stroke();
    pen.globalAlpha = 1;
    pen.fillText(label(v, apart), x_0 - 6, Y(v));
  }
  if (axis) {
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const every = tidy(steps / (width > 500 ? 8 : 4));
    for (let k = 0; k < steps; k += every) pen.fillText(String(k), X(k), y_1 + 6);
  }
  const upright = (k, dashes) => {
    pen.setLineDash(dashes);
    pen.beginPath();
    pen.moveTo(X(k), y_0);
    pen.lineTo(X(k), y_1);
    pen.stroke();
    pen.setLineDash([]);
  };
  pen.strokeStyle = colour.quiet;
  upright(start, [2, 3]);
  pen.save();
  pen.beginPath();
  pen.rect(x_0, y_0 - 2, x_1 - x_0, y_1 - y_0 + 4);
  pen.clip();
  pen.lineJoin = "round";
  for (const { values, count, stride = 1, first = 0, colour: of, thick = 1.6 } of series) {
    pen.strokeStyle = of;
    pen.lineWidth = thick;
    pen.beginPath();
    const clipped = v => Math.max(-1e5, Math.min(1e5, Y(v)));
    const perPixel = Math.max(1, Math.floor((count - 1) / Math.max(1, x_1 - x_0)));
    for (let k = 0; k < count; k += perPixel) {  // of the steps of one pixel the least and the most
      let least = Infinity, most = -Infinity;
      for (let i = k; i < Math.min(count, k + perPixel); i += 1) {
        const v = values[i * stride + first];
        if (v < least) least = v;
        if (v > most) most = v;
      }
      if (!(most >= least)) break;
      pen.lineTo(X(k), clipped(most));
      if (most > least) pen.lineTo(X(k), clipped(least));
    }
    pen.stroke();
  }
  pen.restore();
  if (marks) {  // short strokes at the steps that are not 0
    pen.strokeStyle = colour.warning;
    pen.lineWidth = Math.max(1, (x_1 - x_0) / steps);
    pen.beginPath();
    for (let k = 0; k < marks.length; k += 1) {
      if (!marks[k]) continue;
      pen.moveTo(X(k), y_1);
      pen.lineTo(X(k), y_1 - 9);
    }
    pen.stroke();
    pen.lineWidth = 1;
  }
  if (end < steps) {
    pen.fillStyle = colour.bad;
    pen.textBaseline = "top";
    pen.textAlign = X(end) > x_1 - 80 ? "right" : "left";
    pen.strokeStyle = colour.bad;
    upright(end, [4, 3]);
    if (axis) pen.fillText("diverged", X(end) + (X(end) > x_1 - 80 ? -5 : 5), y_0);
  }
  if (axis && start > 0) {
    pen.fillStyle = colour.quiet;
    pen.textAlign = X(start) > x_1 - 90 ? "right" : "left";
    pen.textBaseline = "bottom";
    pen.fillText("RCAC starts", X(start) + (X(start) > x_1 - 90 ? -5 : 5), y_1 - 2);
  }
  pen.strokeStyle = colour.ink;
  pen.globalAlpha = 0.6;
  upright(cursor, []);
  pen.globalAlpha = 1;
}

// The interval of the first `count` values, a little wider; about zero where it is `even`.
export function span(values, count, even) {
  let least = 0, most = 0;
  for (let i = 0; i < count; i += 1) {
    if (values[i] < least) least = values[i];
    if (values[i] > most) most = values[i];
  }
  if (even) [least, most] = [-Math.max(-least, most), Math.max(-least, most)];
  const margin = 0.08 * (most - least) || 1e-6;
  return [least - margin, most + margin];
}
