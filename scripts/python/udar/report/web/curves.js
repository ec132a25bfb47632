// Curves over time, envelopes along the beam, spectra.
const timeAxis = `time [${timeUnit}]`;
const dashOf = { "-": undefined, "--": [8, 4], ":": [2, 3] };
const wholeTime = () => [begin / timeScale, end / timeScale];
const timeRange = (u, low, high) => (low === null ? wholeTime() : [low, high]);
const overTime = { x: timeAxis, overTime: true };

function drawGauges() {
  const parent = document.getElementById("gauge-charts");
  for (const old of parent.querySelectorAll(".uplot")) {
    const at = timeCharts.findIndex((made) => made.root === old);
    if (at >= 0) timeCharts.splice(at, 1)[0].destroy();
  }
  parent.replaceChildren();
  for (let i = charts.length - 1; i >= 0; i--) if (!charts[i][1].isConnected) charts.splice(i, 1);
  const velocity = document.getElementById("quantity").value === "velocity";
  if (!report.gauges.length) none(parent, sayNone("gauges"));
  for (const gauge of report.gauges) {
    const kinds = velocity ? ["velocity"] : ["mass", "line"]; // the line lies over its mass
    const [scale, unit] = unitFor(largest(gauge.curves.flatMap((curve) => kinds.map((kind) => curve[kind]))),
      velocity ? "m/s" : "m");
    const series = gauge.curves.flatMap((curve) => kinds.map((kind) => ({
      label: (several ? `${report.runs[curve.run].label}: ` : "") + (velocity ? "velocity" : kind),
      stroke: several ? report.runs[curve.run].colour : kind === "mass" ? PALETTE[5] : PALETTE[1],
      ...(kind !== "mass" ? {} : several ? { dash: [3, 3], width: 1.2 } : { width: 3.5 }),
    })));
    const levels = velocity ? [] : gauge.supports;
    chart(parent, {
      ...overTime, title: gauge.title, y: `${velocity ? "v" : "y"} [${unit}]`, series, height: 215,
      xRange: timeRange,
      tables: gauge.curves.map((curve) =>
        [scaled(curve.t, timeScale), ...kinds.map((kind) => scaled(curve[kind], scale))]),
      hooks: { drawClear: [(u) => levels.forEach((level) => drawLevel(u, level / scale, "support"))] },
    });
  }
}

// A horizontal line with its name, drawn below the curves.
function drawLevel(u, value, name) {
  const y = u.valToPos(value, "y", true);
  const { left, top, width, height } = u.bbox;
  if (!(y >= top && y <= top + height)) return;
  const pen = u.ctx;
  pen.save();
  pen.strokeStyle = pen.fillStyle = "#9aa3ad";
  pen.lineWidth = devicePixelRatio;
  pen.beginPath();
  pen.moveTo(left, y);
  pen.lineTo(left + width, y);
  pen.stroke();
  pen.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  pen.textAlign = "right";
  pen.fillText(name, left + width - 4 * devicePixelRatio, y - 4 * devicePixelRatio);
  pen.restore();
}

function drawForces() {
  const parent = document.getElementById("force-charts");
  const known = report.runs.filter((run) => run.forces);
  const labels = known.map((run) => run.forces.curves.map((curve) => curve.label).join());
  if (known.length > 1 && new Set(labels).size === 1) return overlayForces(parent, known);
  for (const run of known) {
    const values = run.forces.curves.map((curve) => curve.values);
    const rest = values.slice(0, -1);
    const all = run.peaks.length > rest.length && rest.length > 1 && largest(values) > 3 * largest(rest);
    const [scale, unit] = unitFor(largest(all ? rest : values), "N");
    const struck = run.supports.some((support) => support.striker !== null);
    const whose = struck ? "Forces on the structure, upwards positive, of strikers where they press" :
      "Forces of the supports on the structure, upwards positive";
    const mean = run.forces.window ? `, mean over ${show(run.forces.window, "s", 3)}` : "";
    chart(parent, {
      ...overTime, xRange: timeRange, y: `force [${unit}]`, height: 240,
      title: `${several ? `${run.label}: ` : ""}${whose}${mean}`,
      series: run.forces.curves.map((curve, k) => ({
        label: curve.label, stroke: PALETTE[k % PALETTE.length], width: Math.max(1.4, 3.2 - 0.9 * k),
        show: !all || k < rest.length })),
      tables: [[scaled(run.forces.t, timeScale), ...run.forces.curves.map((curve) => scaled(curve.values, scale))]],
    });
    if (all) {
      make("p", parent, "Hidden, as it is far larger: the sum over all supports. Click its name.").className = "hint";
    }
    if (run.peaks.length > 7) drawPeaks(parent, run);
  }
}

// A chart for each support, with all runs.
function overlayForces(parent, known) {
  known[0].forces.curves.forEach((curve, k) => {
    const [scale, unit] = unitFor(largest(known.map((run) => run.forces.curves[k].values)), "N");
    chart(parent, {
      ...overTime, xRange: timeRange, y: `force [${unit}]`, height: 220,
      title: `Force of ${curve.label}, upwards positive`,
      series: known.map((run) => ({ stroke: run.colour,
        label: `${run.label}${run.forces.window ? `, mean over ${show(run.forces.window, "s", 3)}` : ""}` })),
      tables: known.map((run) => [scaled(run.forces.t, timeScale), scaled(run.forces.curves[k].values, scale)]),
    });
  });
  for (const run of known) if (run.peaks.length > 7) drawPeaks(parent, run);
}

function drawPeaks(parent, run) {
  const rows = run.supports.map((support, k) => [support.position, run.peaks[k]]).filter(([x]) => x !== null)
    .sort((a, b) => a[0] - b[0]);
  const [scale, unit] = unitFor(largest([rows.map(([, peak]) => peak)]), "N");
  chart(parent, {
    title: `${several ? `${run.label}: ` : ""}Largest force of each support`, x: "x [m]", y: `force [${unit}]`,
    height: 200, tables: [[rows.map(([x]) => x), rows.map(([, peak]) => peak / scale)]],
    series: [{ label: "largest force", stroke: PALETTE[0], fill: "#0072b255",
      paths: uPlot.paths.bars({ size: [0.7, 30] }) }],
  });
}

function drawEnergy() {
  const parent = document.getElementById("energy-charts");
  const known = report.runs.filter((run) => run.energy);
  if (!known.length) return none(parent, "No energies are known.");
  const names = report.energy_lines.filter((line) => known.some((run) => run.energy.parts[line.name]));
  const peak = largest(known.flatMap((run) => Object.values(run.energy.parts)));
  const [scale, unit] = unitFor(peak, "J");
  if (several) {
    const pairs = make("div", parent);
    pairs.className = "pairs";
    for (const line of names) {
      const own = known.filter((run) => run.energy.parts[line.name]);
      chart(pairs, {
        ...overTime, xRange: timeRange, title: line.label, y: `energy [${unit}]`, height: 200,
        series: own.map((run) => ({ label: run.label, stroke: run.colour })),
        tables: own.map((run) => [scaled(run.energy.t, timeScale), scaled(run.energy.parts[line.name], scale)]),
      });
    }
  } else {
    drawParts(parent, known[0].energy, names);
  }
  chart(parent, {
    ...overTime, xRange: timeRange, title: "Error of the balance, relative", y: "|drift| [-]", height: 170, logY: true,
    series: known.map((run) => ({ label: several ? run.label : "|drift|", stroke: several ? run.colour : "#000" })),
    tables: known.map((run) => [scaled(run.energy.t, timeScale),
      Array.from(run.energy.drift, (value) => (Number.isFinite(value) ? Math.max(Math.abs(value), 1e-17) : null))]),
  });
}

// All parts in one chart. A potential that dwarfs all others is hidden with the total until it is asked for.
function drawParts(parent, energy, names) {
  const far = ["load_potential", "total"];
  const near = largest(names.filter((line) => !far.includes(line.name)).map((line) => energy.parts[line.name]));
  const potential = energy.parts.load_potential;
  const hide = potential && near > 0 && Math.min(...potential.map(Math.abs)) > 3 * near ? far : [];
  const [scale, unit] = unitFor(hide.length ? near : largest(Object.values(energy.parts)), "J");
  if (hide.length) {
    make("p", parent, "Hidden, as they are far larger: potential of the load, total. Click their names.")
      .className = "hint";
  }
  chart(parent, {
    ...overTime, xRange: timeRange, y: `energy [${unit}]`, height: 320,
    series: names.map((line) => ({ label: line.label, stroke: line.colour, dash: dashOf[line.dash],
      show: !hide.includes(line.name) })),
    tables: [[scaled(energy.t, timeScale), ...names.map((line) => scaled(energy.parts[line.name], scale))]],
  });
}

// Supports below and above a chart along x.
function shadeSupports(u) {
  const pen = u.ctx;
  const { top, height, left, width } = u.bbox;
  pen.save();
  for (const support of report.runs[0].supports.slice(0, 60)) {
    if (support.floor || support.position === null) continue;
    const a = u.valToPos(support.low, "x", true), b = u.valToPos(support.high, "x", true);
    if (b < left || a > left + width) continue;
    pen.fillStyle = support.striker === null ? "#e9ecef" : "#f9e6da";
    pen.fillRect(Math.max(left, a - devicePixelRatio), top, Math.max(b - a, 2 * devicePixelRatio), height);
  }
  pen.restore();
}

function drawEnvelopes() {
  const parent = document.getElementById("envelope-charts");
  const names = [...new Set(report.runs.flatMap((run) => run.envelope.map((entry) => entry.name)))];
  if (!names.length) {
    const space = report.runs.some((run) => run.space?.colours.length > 1);
    return none(parent, space ? "Where else they are large, the colours of the motion show." :
      "There are no envelopes: they are written when a run ends.");
  }
  for (const name of names) {
    const own = report.runs.filter((run) => run.envelope.some((entry) => entry.name === name));
    const entries = own.map((run) => run.envelope.find((entry) => entry.name === name));
    const [scale, unit] = unitFor(largest(entries.flatMap((entry) => [entry.high, entry.low || []])), entries[0].unit);
    const series = [], bands = [], tables = [];
    entries.forEach((entry, k) => {
      const colour = several ? own[k].colour : PALETTE[0];
      const label = several ? `${own[k].label}: ` : "";
      if (entry.low) bands.push({ series: [series.length + 1, series.length + 2], fill: `${colour}22` });
      series.push({ label: `${label}${entry.low ? "largest" : "largest size"}`, stroke: colour });
      if (entry.low) series.push({ label: `${label}least`, stroke: colour });
      tables.push([Array.from(entry.x), scaled(entry.high, scale), ...(entry.low ? [scaled(entry.low, scale)] : [])]);
    });
    const [top] = entries;
    const where = `: ${show(top.worst, top.unit)} at x = ${show(top.worst_x, "m")}`;
    const worst = several || name === "position" ? "" : where;
    const label = top.label[0].toUpperCase() + top.label.slice(1);
    const places = own.filter((run) => run.x);
    const along = [Math.min(...places.map((run) => run.x[0])), Math.max(...places.map((run) => run.x[1]))];
    chart(parent, { title: label + worst, x: "x along the beam [m]", y: `${name === "position" ? "y " : ""}[${unit}]`,
      series, bands, tables, height: 230, xRange: (u, low, high) => (low === null ? along : [low, high]),
      hooks: { drawClear: [shadeSupports] } });
  }
}

function drawSpectra() {
  const parent = document.getElementById("spectrum-charts");
  if (!report.spectra.length) {
    return none(parent, "No spectra: there are no gauges, or too few or uneven rows.");
  }
  for (const spectrum of report.spectra) {
    const peak = largest(spectrum.curves.map((curve) => curve.amplitude));
    chart(parent, {
      title: spectrum.title, x: "frequency [rad/s]", y: "amplitude [m/s]", height: 250, log: true,
      range: (u, low, high) => [Math.max(low, 1e-7 * peak) / 1.5, 2 * high],
      xRange: (u, low, high) => [low, high],
      series: spectrum.curves.map((curve) => ({
        label: several ? report.runs[curve.run].label : "amplitude",
        stroke: several ? report.runs[curve.run].colour : PALETTE[0], width: 1.2 })),
      tables: spectrum.curves.map((curve) => [Array.from(curve.frequency),
        Array.from(curve.amplitude, (value) => (value > 0 ? value : null))]),
      hooks: { draw: [markFrequencies] },
    });
  }
}

// wf of each run; w and lambda of the lowest modes of the first.
function markFrequencies(u) {
  const marks = report.runs.filter((run) => run.wf)
    .map((run) => [run.wf, several ? `wf ${run.label}` : "wf", several ? run.colour : PALETTE[1], [6, 4]]);
  const first = report.runs[0];
  first.modes.forEach((w, k) => {
    const lambda = first.filtered[k];
    marks.push([w, `w${k + 1}`, "#1b1f24", []]);
    if (lambda && Math.abs(lambda - w) > 0.004 * w) marks.push([lambda, `λ${k + 1}`, PALETTE[2], [2, 3]]);
  });
  const pen = u.ctx;
  const { left, top, width, height } = u.bbox;
  pen.save();
  pen.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  pen.lineWidth = devicePixelRatio;
  pen.textAlign = "left";
  pen.textBaseline = "alphabetic";
  const taken = [];
  for (const [value, name, colour, dash] of marks) {
    const x = u.valToPos(value, "x", true);
    if (!(x >= left && x <= left + width)) continue;
    pen.strokeStyle = pen.fillStyle = colour;
    pen.setLineDash(dash.map((part) => part * devicePixelRatio));
    pen.beginPath();
    pen.moveTo(x, top);
    pen.lineTo(x, top + height);
    pen.stroke();
    const room = pen.measureText(name).width + 4 * devicePixelRatio;
    let row = 0;
    while (taken.some(([a, b, at]) => at === row && a < x + room && b > x)) row++;
    taken.push([x, x + room, row]);
    pen.fillText(name, x + 3 * devicePixelRatio, top + (13 + 14 * row) * devicePixelRatio);
  }
  pen.restore();
}
