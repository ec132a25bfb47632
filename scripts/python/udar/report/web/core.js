// What all parts share: the data, units, charts whose time axes move together.
const report = decode(JSON.parse(document.getElementById("data").textContent));
const several = report.runs.length > 1;
const GREY = "#59636e";
const PALETTE = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];

// Arrays come as bytes in base64.
function decode(value) {
  if (Array.isArray(value)) return value.map(decode);
  if (value === null || typeof value !== "object") return value;
  if (typeof value.bytes === "string" && typeof value.kind === "string") {
    const text = atob(value.bytes);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    const types = { f4: Float32Array, f8: Float64Array, i4: Int32Array };
    return new types[value.kind](bytes.buffer);
  }
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, decode(part)]));
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

// Scale and name of the unit in which something up to `peak` reads well; neither km nor ks.
function unitFor(peak, unit) {
  if (!(peak > 0) || !isFinite(peak) || unit === "1" || unit === "") return [1, unit === "1" ? "-" : unit];
  if (unit === "m" || unit === "s") {
    if (peak >= 0.1) return [1, unit];
    const small = PREFIXES.find(([scale]) => scale < 1 && peak >= scale) || PREFIXES[PREFIXES.length - 1];
    return [small[0], small[1] + unit];
  }
  const [scale, prefix] = PREFIXES.find(([size]) => peak >= size * (1 - 1e-9)) || PREFIXES[PREFIXES.length - 1];
  return [scale, prefix + unit];
}

function show(value, unit, digits = 4) {
  if (value === null || value === undefined || !isFinite(value)) return "-";
  const [scale, name] = unitFor(Math.abs(value), unit);
  return `${Number((value / scale).toPrecision(digits))}${name === "-" ? "" : ` ${name}`}`;
}

const spaced = (count) => String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f");

function span(arrays) {
  let low = Infinity, high = -Infinity;
  for (const values of arrays) {
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return [low, high];
}

const largest = (arrays) => {
  const [low, high] = span(arrays);
  return Math.max(Math.abs(low), Math.abs(high));
};

// uPlot wants null where there is nothing.
const scaled = (values, scale) => Array.from(values, (value) => (Number.isFinite(value) ? value / scale : null));

function make(kind, parent, text = "") {
  const element = document.createElement(kind);
  if (text) element.textContent = text;
  if (parent) parent.appendChild(element);
  return element;
}

const times = report.runs.flatMap((run) => [run.energy?.t, run.forces?.t, run.line?.t, run.space?.t])
  .filter((t) => t && t.length);
const begin = times.length ? Math.min(...times.map((t) => t[0])) : 0;
const end = Math.max(begin + 1e-12, ...times.map((t) => t[t.length - 1]));
const [timeScale, timeUnit] = unitFor(end, "s");

const charts = [];     // all, to fit them to the width
const timeCharts = []; // those with a time axis, which zoom together
let zooming = false;
let hidden = true;     // no zoom is handed on while charts are made

function zoomTime(low, high, source = null) {
  if (zooming) return;
  zooming = true;
  for (const chart of timeCharts) {
    if (chart !== source) chart.setScale("x", { min: low, max: high });
  }
  zooming = false;
}

// Numbers that the axis has room for, all with as many decimals.
function ticks(u, splits) {
  const shown = splits.filter((value) => value !== null);
  const step = shown.length > 1 ? Math.abs(shown[1] - shown[0]) : 1;
  const large = Math.max(...shown.map(Math.abs));
  if (large >= 1e6 || (large > 0 && large < 1e-4)) {
    return splits.map((value) => (value === null ? "" : String(Number(value.toPrecision(4)))));
  }
  let decimals = 0;
  const uneven = (size) => Math.abs(size - Math.round(size)) > 0.01 * size;
  while (decimals < 9 && uneven(step * 10 ** decimals)) decimals++;
  return splits.map((value) => (value === null ? "" : value.toFixed(decimals)));
}

// On a logarithmic axis: at most seven powers of ten, and 2 and 5 of them where there are few.
function logSplits(u, axis, low, high) {
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(1, Math.ceil((last - first + 1) / 7));
  const found = [];
  for (let power = first - 1; power <= last + 1; power += step) {
    for (const lead of step > 1 || last - first > 2 ? [1] : [1, 2, 5]) {
      const value = lead * 10 ** power;
      if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) found.push(value);
    }
  }
  return found;
}

const logTicks = (u, splits) => splits.map((value) => (value >= 0.00999 && value < 1e5 ?
  String(Number(value.toPrecision(2))) : value.toExponential(0).replace("e+", "e")));
const logAxis = { splits: logSplits, filter: (u, splits) => splits, values: logTicks };

// A chart of tables [x, values, values, ...] joined on x; `series` describes their columns in order.
function chart(parent, given) {
  const holder = make("div", parent);
  holder.className = "chart";
  if (given.title) make("h3", holder, given.title);
  const data = given.tables.length > 1 ? uPlot.join(given.tables) : given.tables[0];
  const width = Math.max(300, holder.clientWidth);
  const axis = { stroke: "#1b1f24", grid: { stroke: "#e6e9ed", width: 1 }, ticks: { stroke: "#c8ced6", size: 5 },
    font: "12px system-ui, sans-serif", labelFont: "13px system-ui, sans-serif" };
  const options = {
    width, height: given.height || 230, title: "",
    scales: { x: { time: false, distr: given.log ? 3 : 1, ...(given.xRange ? { range: given.xRange } : {}) },
      y: { distr: given.log || given.logY ? 3 : 1, ...(given.range ? { range: given.range } : {}) } },
    axes: [
      { ...axis, label: given.x, space: 75, labelSize: 20, size: 32, ...(given.log ? logAxis : { values: ticks }) },
      { ...axis, label: given.y, labelSize: 22, size: 62, ...(given.log || given.logY ? logAxis : { values: ticks }) }],
    legend: { show: given.legend !== false, live: true },
    cursor: { drag: { x: true, y: false, uni: 20 }, focus: { prox: 24 },
      ...(given.overTime ? { sync: { key: "time" } } : {}) },
    focus: { alpha: 0.35 },
    series: [{ label: given.x.replace("along the beam ", "").replace("frequency", "w"),
      value: (u, value) => (value === null ? "" : Number(value.toPrecision(7))) },
      ...given.series.map((entry) => ({
        width: 1.6, spanGaps: true, points: { show: false }, scale: "y", ...entry,
        value: (u, value) => (value === null || value === undefined ? "" : Number(value.toPrecision(5))),
      }))],
    bands: given.bands,
    hooks: given.hooks || {},
    padding: [8, 26, 0, 0],
  };
  if (given.overTime) {
    options.hooks.setScale = [...(options.hooks.setScale || []),
      (u, key) => { if (key === "x" && !hidden) zoomTime(u.scales.x.min, u.scales.x.max, u); }];
  }
  const made = new uPlot(options, data, holder);
  charts.push([made, holder]);
  if (given.overTime) timeCharts.push(made);
  return made;
}

const sayNone = (what) => (report.runs.every((run) => run.known) ? `This run has no ${what}.` :
  `Nothing is known of ${what}.`);
const none = (parent, text) => { make("p", parent, text).className = "none"; };

function fitCharts(width = 0) {
  hidden = true;
  for (const [made, holder] of charts) {
    made.setSize({ width: Math.max(300, width || holder.clientWidth), height: made.height });
  }
  hidden = false;
}
