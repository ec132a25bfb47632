// Puts the page together, and what its controls do.
function fill(select, entries, chosen) {
  select.replaceChildren(...entries.map(([value, text]) => {
    const option = make("option", null, text);
    option.value = value;
    return option;
  }));
  select.value = String(chosen);
}

// Times at which any run has a frame.
function frameTimes() {
  const all = report.runs.flatMap((run) => Array.from((run.line || run.space)?.t || []));
  return [...new Set(all)].sort((a, b) => a - b);
}

class Motion {
  constructor() {
    this.times = frameTimes();
    this.views = [];
    this.element = (id) => document.getElementById(id);
    const section = this.element("motion");
    if (!this.times.length) {
      this.element("motion-controls").remove();
      this.element("space-controls").remove();
      none(section, "There are no rows of fields.");
      return;
    }
    if (report.runs.some((run) => run.line?.t.length)) this.views.push(new LineView(this.element("line-chart")));
    this.spaces = report.runs.filter((run) => run.space);
    if (this.spaces.length) this.prepareSpace();
    else this.element("space-controls").remove();
    const choice = this.element("view");
    const near = choice.querySelector("[value=near]");
    if (!report.runs.some((run) => run.line && run.touched)) near.remove();
    else if (longFlight) choice.value = "near";
    const slider = this.element("frame");
    slider.max = this.times.length - 1;
    slider.addEventListener("input", () => this.show(Number(slider.value)));
    this.element("view").addEventListener("change", () => this.show(Number(slider.value)));
    this.element("play").addEventListener("click", () => this.play());
    this.show(this.mostBent());
  }

  prepareSpace() {
    this.space = new SpaceView(this.element("space-view"));
    fill(this.element("space-run"), this.spaces.map((run, k) => [k, run.label]), 0);
    if (this.spaces.length < 2) this.element("run-choice").remove();
    const take = () => {
      const run = this.spaces[Number(this.element("space-run")?.value || 0)];
      this.space.take(run);
      fill(this.element("factor"), FACTORS.map((factor) => [factor, String(factor)]), this.space.proposedFactor());
      const moments = run.space.colours.map((field) => (field.unit === "N m" ? largest([field.values]) : -1));
      const chosen = Math.max(0, moments.findIndex((size) => size > 0 && size === Math.max(...moments)));
      fill(this.element("colour"), [[-1, "none"], ...run.space.colours.map((field, k) => [k, field.label])],
        run.space.colours.length ? chosen : -1);
      set();
    };
    const set = () => {
      this.space.factor = Number(this.element("factor").value);
      this.space.colour = Number(this.element("colour").value);
      if (this.views.includes(this.space)) this.space.draw();
    };
    this.element("space-run")?.addEventListener("change", take);
    this.element("factor").addEventListener("change", set);
    this.element("colour").addEventListener("change", set);
    take();
    this.views.push(this.space);
  }

  // The frame in which the first run is bent most.
  mostBent() {
    const run = report.runs.find((one) => one.line?.t.length || one.space?.t.length);
    const { t } = run.line || run.space;
    const [from, to] = run.touched || [begin, end];
    let best = 0, most = -1;
    for (let k = 0; k < t.length; k++) {
      if (most >= 0 && (t[k] < from || t[k] > to)) continue;
      const size = run.line ? this.bending(run.line, k) : this.deformation(run.space, k);
      if (size > most) [best, most] = [k, size];
    }
    return this.times.indexOf(t[best]);
  }

  bending(line, k) {
    const n = line.x.length;
    const y = line.line.subarray(k * n, k * n + n);
    const [mean, slope] = wholeMotion(line.x, y);
    return y.reduce((most, value, i) => Math.max(most, Math.abs(value - mean - slope * line.x[i])), 0);
  }

  deformation(space, k) {
    return largest([space.deformation.subarray(k * space.place.length, (k + 1) * space.place.length)]);
  }

  show(frame) {
    const at = this.times[frame];
    this.element("frame").value = frame;
    this.element("frame-time").textContent = `t = ${show(at, "s", 6)}, frame ${frame + 1} of ${this.times.length}`;
    for (const view of this.views) view.show(at, this.element("view").value);
  }

  play() {
    const button = this.element("play");
    if (this.timer) {
      clearInterval(this.timer);
      this.timer = null;
      button.textContent = "play";
      return;
    }
    button.textContent = "stop";
    const slider = this.element("frame");
    this.timer = setInterval(() => this.show((Number(slider.value) + 1) % this.times.length), 50);
  }
}

// What flies for most of the time is first shown from its contact on.
const touched = report.runs.map((run) => run.touched).filter((spans) => spans);
const longFlight = touched.length > 0 && Math.min(...touched.map((spans) => spans[0])) - begin > 0.3 * (end - begin);

function prepareZoom() {
  document.getElementById("zoom-all").addEventListener("click", () => zoomTime(...wholeTime()));
  const [later, close] = ["zoom-later", "zoom-contact"].map((id) => document.getElementById(id));
  if (!touched.length) {
    later.remove();
    close.remove();
    return;
  }
  const first = Math.min(...touched.map((spans) => spans[0])), last = Math.max(...touched.map((spans) => spans[1]));
  const room = 0.15 * (last - first) || 0.01 * (end - begin);
  const within = (from, to) => zoomTime(Math.max(begin, from) / timeScale, Math.min(end, to) / timeScale);
  close.addEventListener("click", () => within(first - room, last + room));
  const afterFlight = () => within(first - 0.1 * (end - first), end);
  later.addEventListener("click", afterFlight);
  if (longFlight) afterFlight();
}

drawContacts();
drawForces();
const motion = new Motion();
drawGauges();
drawEnvelopes();
drawEnergy();
drawSpectra();
prepareZoom();
hidden = false;
document.getElementById("quantity").addEventListener("change", () => {
  hidden = true;
  drawGauges();
  hidden = false;
});
let waiting = null;
addEventListener("resize", () => {
  clearTimeout(waiting);
  waiting = setTimeout(() => { fitCharts(); motion.space?.draw(); }, 100);
});
addEventListener("beforeprint", () => fitCharts(700));
addEventListener("afterprint", () => fitCharts());
document.body.dataset.ready = "yes"; // all is drawn
