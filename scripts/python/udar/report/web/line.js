// A beam in motion, from the side.
function nearestFrame(t, at) {
  let low = 0, high = t.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (t[middle] < at) low = middle + 1;
    else high = middle;
  }
  return low > 0 && at - t[low - 1] < t[low] - at ? low - 1 : low;
}

function interpolate(t, values, at) {
  const k = Math.min(Math.max(nearestFrame(t, at), 0), t.length - 1);
  return values[k];
}

// Mean and slope of the line: how it has moved as a whole.
function wholeMotion(x, y) {
  let n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (let i = 0; i < x.length; i++) {
    n += 1; sx += x[i]; sy += y[i]; sxx += x[i] * x[i]; sxy += x[i] * y[i];
  }
  const slope = (n * sxy - sx * sy) / (n * sxx - sx * sx || 1);
  return [(sy - slope * sx) / n, slope];
}

class LineView {
  constructor(parent) {
    this.runs = report.runs.filter((run) => run.line && run.line.t.length);
    this.view = "position";
    this.at = 0;
    this.measure();
    const series = this.runs.flatMap((run) => [
      { label: `${several ? `${run.label}: ` : ""}line`, stroke: several ? run.colour : PALETTE[0], width: 2.4 },
      ...(run.line.masses ? [this.dots(several ? `${run.label}: masses` : "masses", several ? run.colour : PALETTE[1])]
        : []),
    ]);
    this.chart = chart(parent, {
      x: "x along the beam [m]", y: this.label, height: 340, series, tables: this.tables(),
      range: () => this.limits(), hooks: { drawClear: [(u) => this.drawSupports(u)] },
    });
  }

  dots(label, colour) {
    return { label, width: 0, paths: () => null, stroke: colour, points: { show: true, size: 6, fill: colour } };
  }

  get deformed() {
    return this.view === "deformation";
  }

  // Limits of y in all views.
  measure() {
    const [whole, near, bent] = Array.from({ length: 3 }, () => [Infinity, -Infinity]);
    const widen = (limits, value) => { // what is no number widens nothing
      if (value < limits[0]) limits[0] = value;
      if (value > limits[1]) limits[1] = value;
    };
    for (const { line, supports, touched } of this.runs) {
      const n = line.x.length;
      for (let k = 0; k < line.t.length; k++) {
        const y = line.line.subarray(k * n, k * n + n);
        const [mean, slope] = wholeMotion(line.x, y);
        for (let i = 0; i < n; i++) {
          widen(whole, y[i]);
          if (touched && line.t[k] >= touched[0] && line.t[k] <= touched[1]) widen(near, y[i]);
          widen(bent, y[i] - mean - slope * line.x[i]);
        }
      }
      for (const support of supports) {
        for (const y of support.flat && support.striker === null ? support.face : []) {
          if (y !== null) [whole, near].forEach((limits) => widen(limits, y));
        }
      }
    }
    const wide = ([low, high]) => {
      if (low > high) return [-1, 1];
      const room = 0.08 * (high - low) || 1e-3;
      return [low - room, high + room];
    };
    this.ranges = { position: wide(whole), near: wide(near), deformation: wide(bent) };
    this.units = Object.fromEntries(Object.entries(this.ranges).map(([view, range]) =>
      [view, unitFor(Math.max(...range.map(Math.abs)), "m")]));
  }

  get scale() {
    return this.units[this.view][0];
  }

  get label() {
    const unit = this.units[this.view][1];
    return this.deformed ? `deformation [${unit}]` : `y [${unit}], not to scale with x`;
  }

  limits() {
    return this.ranges[this.view].map((value) => value / this.scale);
  }

  tables() {
    const { scale } = this;
    return this.runs.map(({ line }) => {
      const n = line.x.length;
      const k = nearestFrame(line.t, this.at);
      const y = line.line.subarray(k * n, k * n + n);
      const [mean, slope] = this.deformed ? wholeMotion(line.x, y) : [0, 0];
      const of = (values) => Array.from(values, (value, i) =>
        (Number.isFinite(value) ? (value - mean - slope * line.x[i]) / scale : null));
      return [Array.from(line.x), of(y), ...(line.masses ? [of(line.masses.subarray(k * n, k * n + n))] : [])];
    });
  }

  show(at, view) {
    [this.at, this.view] = [at, view];
    const tables = this.tables();
    this.chart.axes[1].label = this.label;
    this.chart.setData(tables.length > 1 ? uPlot.join(tables) : tables[0]);
  }

  drawSupports(u) {
    if (this.deformed) return shadeSupports(u);
    const pen = u.ctx;
    const run = this.runs[0];
    const { left, top, width, height } = u.bbox;
    const px = (x) => u.valToPos(x, "x", true), py = (y) => u.valToPos(y / this.scale, "y", true);
    const frame = nearestFrame(run.line.t, this.at);
    pen.save();
    pen.beginPath();
    pen.rect(left, top, width, height);
    pen.clip();
    pen.fillStyle = "#d5dae0";
    pen.strokeStyle = GREY;
    pen.lineWidth = devicePixelRatio;
    run.supports.forEach((support, k) => {
      if (!support.flat) return;
      const lift = run.line.lift ? run.line.lift[frame * run.supports.length + k] : 0;
      if (support.striker !== null) return this.drawStriker(pen, run, support, px, py);
      const foot = (support.side > 0 ? 1 : -1) * 14 * devicePixelRatio;
      pen.beginPath();
      if (support.high > support.low) {
        support.x.forEach((x, i) => pen.lineTo(px(x), py(support.face[i] + lift)));
        pen.lineTo(px(support.x[support.x.length - 1]), py(support.face[support.face.length - 1] + lift) + foot);
        pen.lineTo(px(support.x[0]), py(support.face[0] + lift) + foot);
      } else {
        const x = px(support.position), y = py(support.face[0] + lift);
        pen.moveTo(x, y);
        pen.lineTo(x + Math.abs(foot) / 2, y + foot);
        pen.lineTo(x - Math.abs(foot) / 2, y + foot);
      }
      pen.closePath();
      pen.fill();
      pen.stroke();
    });
    pen.restore();
  }

  drawStriker(pen, run, support, px, py) {
    if (!run.strikers) return;
    const y = py(interpolate(run.strikers.t, run.strikers.positions[support.striker], this.at));
    const half = 12 * devicePixelRatio;
    pen.save();
    pen.fillStyle = "#f0c9b0";
    pen.strokeStyle = "#b84f00";
    pen.fillRect(px(support.position) - half, y, 2 * half, (support.side > 0 ? -1.6 : 1.6) * half);
    pen.strokeRect(px(support.position) - half, y, 2 * half, (support.side > 0 ? -1.6 : 1.6) * half);
    pen.restore();
  }
}
