// Who touched what and when: x against time.
const WARM = ["#fca50a", "#f37819", "#dd513a", "#bc3754", "#932667", "#6a176e", "#420a68", "#160b39"];
const RESTING = "#56b4e9", TOUCHING = "#8fc9a9", ABOVE = "#e3b778", STRIKING = "#e8a27a";

function warm(share) {
  const at = Math.min(Math.max(share, 0), 1) * (WARM.length - 1);
  const k = Math.min(Math.floor(at), WARM.length - 2);
  const part = (text, i) => parseInt(text.slice(1 + 2 * i, 3 + 2 * i), 16);
  const mixed = [0, 1, 2].map((i) => part(WARM[k], i) + (at - k) * (part(WARM[k + 1], i) - part(WARM[k], i)));
  return `rgb(${mixed.map(Math.round).join(",")})`;
}

function drawContacts() {
  const parent = document.getElementById("contact-charts");
  const known = report.runs.filter((run) => run.contact && run.x);
  if (!report.runs.some((run) => run.supports.length)) return none(parent, sayNone("supports"));
  if (!known.length) return none(parent, "Nothing is known of the contacts.");
  const [low, high] = span(known.map((run) => run.contact.impacts.speed));
  const logarithmic = low > 0 && high > 30 * low;
  const least = logarithmic ? Math.max(low, 1e-4 * high) : 0;
  const shareOf = (speed) => (logarithmic ? Math.log(Math.max(speed, least) / least) / Math.log(high / least)
    : speed / (high || 1));
  for (const run of known) contactChart(parent, run, shareOf);
  drawScale(parent, known, least, high, logarithmic);
}

function contactChart(parent, run, shareOf) {
  const { impacts, rests, spans } = run.contact;
  const room = 0.04 * (run.x[1] - run.x[0] || 1);
  const words = [];
  if (run.contact.count) words.push(`${spaced(run.contact.count)} impacts`);
  if (spans.t0?.length) {
    words.push(run.supports.every((support) => support.striker !== null) ? "forces of strikers" : "forces of supports");
  };
  if (!words.length && !rests.t0.length) words.push("no contact");
  if (run.contact.cell) {
    words.push(`counted in cells of ${show(run.contact.cell[0], "s", 2)} by ${show(run.contact.cell[1], "m", 2)}`);
  }
  const made = chart(parent, {
    ...overTime, xRange: timeRange, title: `${several ? `${run.label}: ` : ""}Contacts: ${words.join(", ")}`,
    y: "x [m]", height: 270, legend: false, range: () => [run.x[0] - room, run.x[1] + room],
    tables: [[[begin / timeScale, end / timeScale], [null, null]]], series: [{ label: "x" }],
    hooks: {
      drawClear: [(u) => drawPlaces(u, run)],
      draw: [(u) => drawMarks(u, run, shareOf)],
      setCursor: [(u) => tellNearest(u, run)],
    },
  });
  const tip = make("div", made.over);
  tip.className = "tip";
  made.tip = tip;
}

function drawPlaces(u, run) {
  const pen = u.ctx;
  const { left, width } = u.bbox;
  pen.save();
  pen.fillStyle = "#e9ecef";
  for (const support of run.supports.length <= 60 ? run.supports : []) {
    if (support.floor || support.position === null) continue;
    const a = u.valToPos(support.high, "y", true), b = u.valToPos(support.low, "y", true);
    pen.fillRect(left, a - devicePixelRatio, width, Math.max(b - a, 2 * devicePixelRatio));
  }
  pen.restore();
}

function drawMarks(u, run, shareOf) {
  const { impacts, rests, spans } = run.contact;
  const pen = u.ctx;
  const dot = devicePixelRatio;
  const { left, top, width, height } = u.bbox;
  const px = (t) => u.valToPos(t / timeScale, "x", true);
  const py = (x) => u.valToPos(x, "y", true);
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  const both = new Set(run.supports.map((support) => support.side)).size > 1;
  for (let i = 0; i < (spans.t0?.length || 0); i++) {
    const support = run.contact.together ? null : run.supports[spans.support[i]];
    const a = px(spans.t0[i]), b = px(spans.t1[i]);
    const half = barHeight(run, support, dot, py);
    let from = py(support ? support.high : run.x[1]) - half, to = py(support ? support.low : run.x[0]) + half;
    if (both && support) {
      if (support.side > 0) from = py(support.high);
      else to = py(support.low);
    }
    pen.fillStyle = support && support.striker !== null ? STRIKING : isAbove(run, support) ? ABOVE : TOUCHING;
    pen.fillRect(a, from, Math.max(b - a, 2 * dot), to - from);
  }
  const thick = Math.max(3, Math.min(9, height / dot / 60)) * dot;
  pen.fillStyle = RESTING;
  for (let i = 0; i < rests.t0.length; i++) {
    const a = px(rests.t0[i]);
    pen.fillRect(a, py(rests.x[i]) - thick / 2, Math.max(px(rests.t1[i]) - a, dot), thick);
  }
  const cell = run.contact.cell;
  const wide = cell ? Math.max(px(cell[0]) - px(0), dot) : 0;
  const high = cell ? Math.max(py(0) - py(cell[1]), dot) : 0;
  const order = run.contact.order ||= Uint32Array.from(impacts.speed.keys())
    .sort((i, j) => impacts.speed[i] - impacts.speed[j]);
  const size = Math.max(2.2, Math.min(5, 90 / Math.sqrt(order.length + 1))) * dot;
  let level = -1; // of 64 colours; in the order of speed they change 64 times
  for (const i of order) {
    const x = px(impacts.t[i]), y = py(impacts.x[i]);
    if (x < left - size || x > left + width + size) continue;
    const own = Math.round(63 * shareOf(impacts.speed[i]));
    if (own !== level) [level, pen.fillStyle] = [own, warm(own / 63)];
    if (cell) {
      pen.fillRect(x - wide / 2, y - high / 2, wide + dot, high + dot); // no seams between cells
    } else {
      pen.beginPath();
      pen.arc(x, y, size, 0, 7);
      pen.fill();
    }
  }
  pen.restore();
}

// One above the structure, where there are some below it, too.
function isAbove(run, support) {
  return support && support.striker === null && support.side < 0 && run.supports.some((other) => other.side > 0);
}

// Bars of points are thick enough to be seen, and do not run into each other.
function barHeight(run, support, dot, py) {
  const known = run.supports.map((other) => other.position).filter((x) => x !== null);
  const places = [...new Set(known)].sort((a, b) => a - b);
  const gaps = places.slice(1).map((x, k) => x - places[k]);
  const room = gaps.length ? 0.4 * (py(0) - py(Math.min(...gaps))) : Infinity;
  return support && support.high > support.low ? 0 : Math.max(dot, Math.min(6 * dot, room));
}

function tellNearest(u, run) {
  const { impacts } = run.contact;
  const { left, top } = u.cursor;
  if (!u.tip) return;
  let best = -1, distance = 14 * 14;
  if (left >= 0) {
    for (let i = 0; i < impacts.t.length; i++) {
      const dx = u.valToPos(impacts.t[i] / timeScale, "x") - left, dy = u.valToPos(impacts.x[i], "y") - top;
      if (dx * dx + dy * dy < distance) [best, distance] = [i, dx * dx + dy * dy];
    }
  }
  u.tip.style.display = best < 0 ? "none" : "block";
  if (best < 0) return;
  const count = impacts.count[best];
  const [speed, impulse] = [show(impacts.speed[best], "m/s"), show(impacts.impulse[best], "N s")];
  u.tip.textContent = `t = ${show(impacts.t[best], "s", 6)}, x = ${show(impacts.x[best], "m")}: ` +
    (count > 1 ? `${spaced(count)} impacts up to ${speed}, in all ${impulse}` : `${speed}, ${impulse}`);
  u.tip.style.left = `${Math.min(left + 12, u.over.clientWidth - u.tip.offsetWidth - 4)}px`;
  u.tip.style.top = `${Math.max(0, top - 28)}px`;
}

function drawScale(parent, known, least, high, logarithmic) {
  const line = make("div", parent);
  line.className = "scale";
  if (known.some((run) => run.contact.count) && high > 0) {
    make("span", line, `impact speed ${show(least, "m/s", 2)}`);
    const bar = make("canvas", line);
    [bar.width, bar.height] = [180, 12];
    const pen = bar.getContext("2d");
    for (let i = 0; i < 180; i++) {
      pen.fillStyle = warm(i / 179);
      pen.fillRect(i, 0, 1, 12);
    }
    make("span", line, `${show(high, "m/s", 3)}${logarithmic ? ", logarithmic" : ""}`);
  }
  const kinds = known.flatMap((run) => {
    const pressing = Array.from(run.contact.spans.support || [], (k) => {
      const support = run.contact.together ? null : run.supports[k];
      return support && support.striker !== null ? "striker" : support && isAbove(run, support) ? "above" : "touch";
    });
    return run.contact.rests.t0.length ? ["rest", ...pressing] : pressing;
  });
  for (const [kind, colour, name] of [["rest", RESTING, "mass at rest on a support"],
    ["touch", TOUCHING, "support presses"], ["above", ABOVE, "support above presses"],
    ["striker", STRIKING, "striker presses"]]) {
    if (!kinds.includes(kind)) continue;
    const key = make("span", line);
    key.className = "key";
    key.style.background = colour;
    make("span", line, name);
  }
}
