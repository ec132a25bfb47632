// A structure in space, turned by the mouse: y is up.
const COLD = ["#fde725", "#a0da39", "#4ac16d", "#1fa187", "#277f8e", "#365c8d", "#46327e", "#440154"].reverse();

function cold(share) {
  const at = Math.min(Math.max(share, 0), 1) * (COLD.length - 1);
  const k = Math.min(Math.floor(at), COLD.length - 2);
  const part = (text, i) => parseInt(text.slice(1 + 2 * i, 3 + 2 * i), 16);
  const mixed = [0, 1, 2].map((i) => part(COLD[k], i) + (at - k) * (part(COLD[k + 1], i) - part(COLD[k], i)));
  return `rgb(${mixed.map(Math.round).join(",")})`;
}

class SpaceView {
  constructor(parent) {
    this.canvas = make("canvas", parent);
    this.scaleLine = make("div", parent);
    this.scaleLine.className = "scale";
    this.reset();
    this.at = 0;
    this.factor = 1;
    this.colour = -1;
    this.deformed = false;
    this.listen();
  }

  reset() {
    [this.turn, this.lift, this.zoom] = [0.52, 0.36, 1];
  }

  listen() {
    let last = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.turn += (event.clientX - last[0]) * 0.008;
      this.lift = Math.max(-1.5, Math.min(1.5, this.lift + (event.clientY - last[1]) * 0.008));
      last = [event.clientX, event.clientY];
      this.draw();
    });
    this.canvas.addEventListener("pointerup", () => { last = null; });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom *= Math.exp(-0.0012 * event.deltaY);
      this.draw();
    }, { passive: false });
    this.canvas.addEventListener("dblclick", () => { this.reset(); this.draw(); });
  }

  take(run) {
    this.run = run;
    const { place, deformation, t, rigid, faces } = run.space;
    const n = place.length / 3;
    // The box of all frames in true size, and of the supports.
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const add = (x, i) => { if (x < low[i]) low[i] = x; if (x > high[i]) high[i] = x; };
    for (let k = 0; k < t.length; k += Math.max(1, Math.floor(t.length / 40))) {
      const points = this.points(k, 1);
      for (let i = 0; i < points.length; i++) add(points[i], i % 3);
    }
    if (!t.length) place.forEach((x, i) => add(x, i % 3));
    for (const face of faces) face.corners.forEach((x, i) => add(x, i % 3));
    this.centre = low.map((x, i) => (x + high[i]) / 2);
    this.corners = [];
    for (let i = 0; i < 8; i++) for (let j = 0; j < 3; j++) this.corners.push((i >> j) & 1 ? high[j] : low[j]);
    this.size = Math.hypot(...low.map((x, i) => high[i] - x)) || 1;
    this.largest = deformation.length ? largest([deformation]) : 0;
    this.nodes = n;
  }

  // Places of all nodes in a frame, deformations drawn `factor` times as large.
  points(frame, factor) {
    const { place, deformation, rigid } = this.run.space;
    const out = new Float64Array(place.length);
    const a = this.deformed ? [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0] : rigid.subarray(12 * frame, 12 * frame + 12);
    const from = frame * place.length;
    for (let i = 0; i < place.length; i += 3) {
      for (let j = 0; j < 3; j++) {
        out[i + j] = place[i] * a[j] + place[i + 1] * a[3 + j] + place[i + 2] * a[6 + j] + a[9 + j]
          + factor * deformation[from + i + j];
      }
    }
    return out;
  }

  show(at, view) {
    [this.at, this.deformed] = [at, view === "deformation"];
    this.draw();
  }

  // Pixels a metre, so that the box is seen as a whole from any side.
  fit() {
    const { width, height } = this.canvas;
    this.pixels = 1;
    const seen = this.project(this.corners);
    const extent = (k) => {
      const [low, high] = span([seen.filter((_, i) => i % 3 === k)]);
      return high - low || 1e-9;
    };
    this.pixels = this.zoom * Math.min(0.86 * width / extent(0), 0.84 * height / extent(1));
  }

  project(points) {
    const { width, height } = this.canvas;
    const scale = this.pixels;
    const [ct, st, cl, sl] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.lift), Math.sin(this.lift)];
    const out = new Float64Array(points.length);
    for (let i = 0; i < points.length; i += 3) {
      const x = points[i] - this.centre[0], y = points[i + 1] - this.centre[1], z = points[i + 2] - this.centre[2];
      const away = x * st - z * ct;
      out[i] = width / 2 + scale * (x * ct + z * st);
      out[i + 1] = height / 2 - scale * (y * cl + away * sl);
      out[i + 2] = away * cl - y * sl; // depth, larger is behind
    }
    return out;
  }

  draw() {
    const { space } = this.run;
    const ratio = devicePixelRatio;
    const wide = this.canvas.clientWidth * ratio, high = this.canvas.clientHeight * ratio;
    if (this.canvas.width !== Math.round(wide) || this.canvas.height !== Math.round(high)) {
      [this.canvas.width, this.canvas.height] = [Math.round(wide), Math.round(high)];
    }
    const pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, wide, high);
    this.fit();
    if (!this.deformed) this.drawFaces(pen);
    if (!space.t.length) return;
    const frame = nearestFrame(space.t, this.at);
    const seen = this.project(this.points(frame, this.factor));
    const count = space.edges.length / 2;
    const field = space.colours[this.colour];
    const top = field ? largest([field.values]) : 1;
    pen.lineCap = "round";
    if (!count) {
      pen.fillStyle = "#31557a";
      const dot = 1.3 * ratio;
      for (let i = 0; i < seen.length; i += 3) pen.fillRect(seen[i] - dot, seen[i + 1] - dot, 2 * dot, 2 * dot);
    }
    const depth = (e) => seen[3 * space.edges[2 * e] + 2] + seen[3 * space.edges[2 * e + 1] + 2];
    const order = Array.from({ length: count }, (_, e) => e).sort((a, b) => depth(b) - depth(a));
    const thin = count > 1500 ? 0.8 : 1.6;
    for (const e of order) {
      const a = 3 * space.edges[2 * e], b = 3 * space.edges[2 * e + 1];
      pen.strokeStyle = field ? cold(field.values[e] / (top || 1)) : "#31557a";
      pen.lineWidth = Math.max(thin * ratio, Math.min(2 * space.radius[e] * this.pixels, 9 * ratio));
      pen.beginPath();
      pen.moveTo(seen[a], seen[a + 1]);
      pen.lineTo(seen[b], seen[b + 1]);
      pen.stroke();
    }
    this.drawAxes(pen, ratio);
    this.tellScale(field, top);
  }

  drawFaces(pen) {
    const { space, supports } = this.run;
    const row = space.t.length ? nearestFrame(space.t, this.at) * supports.length : 0;
    for (const face of space.faces) {
      const lift = space.lift && supports[face.support].flat ? space.lift[row + face.support] : 0;
      const seen = this.project(Float64Array.from(face.corners, (x, i) => x + (i % 3 === 1 ? lift : 0)));
      pen.beginPath();
      for (let i = 0; i < seen.length; i += 3) pen.lineTo(seen[i], seen[i + 1]);
      pen.closePath();
      pen.fillStyle = "#dfe3e799";
      pen.strokeStyle = "#9aa3ad";
      pen.lineWidth = (seen.length > 6 ? 1 : 3) * devicePixelRatio;
      pen.fill();
      pen.stroke();
    }
  }

  // Directions of the axes, and a length.
  drawAxes(pen, ratio) {
    const [x0, y0, long] = [46 * ratio, this.canvas.height - 40 * ratio, 30 * ratio];
    const [ct, st, cl, sl] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.lift), Math.sin(this.lift)];
    pen.font = `${13 * ratio}px system-ui, sans-serif`;
    pen.strokeStyle = pen.fillStyle = "#1b1f24";
    pen.lineWidth = 1.5 * ratio;
    pen.textAlign = "center";
    for (const [name, dx, dy] of [["x", ct, -st * sl], ["y", 0, -cl], ["z", st, ct * sl]]) {
      pen.beginPath();
      pen.moveTo(x0, y0);
      pen.lineTo(x0 + long * dx, y0 + long * dy);
      pen.stroke();
      pen.fillText(name, x0 + 1.35 * long * dx, y0 + 1.35 * long * dy + 4 * ratio);
    }
    const power = 10 ** Math.floor(Math.log10(120 * ratio / this.pixels));
    const length = [5, 2, 1].map((k) => k * power).find((k) => k * this.pixels <= 130 * ratio) || power;
    const left = 110 * ratio;
    pen.beginPath();
    pen.moveTo(left, y0);
    pen.lineTo(left + length * this.pixels, y0);
    pen.stroke();
    pen.fillText(show(length, "m"), left + length * this.pixels / 2, y0 - 6 * ratio);
  }

  tellScale(field, top) {
    this.scaleLine.replaceChildren();
    if (!field) return;
    make("span", this.scaleLine, `${field.label}, largest size over the run: 0`);
    const bar = make("canvas", this.scaleLine);
    bar.className = "bar";
    bar.style.cssText = "width: 180px; height: 12px; border: none";
    [bar.width, bar.height] = [180, 12];
    const pen = bar.getContext("2d");
    for (let i = 0; i < 180; i++) {
      pen.fillStyle = cold(i / 179);
      pen.fillRect(i, 0, 1, 12);
    }
    make("span", this.scaleLine, show(top, field.unit));
  }

  // 1, 2, 5, 10, ... so that the largest deformation is a twelfth of the structure.
  proposedFactor() {
    const wanted = this.largest > 0 ? 0.08 * this.size / this.largest : 1;
    return FACTORS.filter((factor) => factor <= Math.max(wanted, 1)).pop();
  }
}

const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];
