// Plays the run of this page: draws its map as the page of the viewer does, and moves
// the charts' cursors and the table with it. data.rs in the scorer's source has the
// meaning of the numbers.
import { MapView, Track } from './draw.js';

const MOST_PLAY_S = 20; // a whole run takes at most this long, unless a pace was chosen
const all = (what) => [...document.querySelectorAll(what)];
const byId = (id) => document.getElementById(id);
addEventListener('error', (event) => {
  byId('trouble').textContent = `The player does not work here: ${event.message}`;
  byId('trouble').hidden = false;
  document.body.classList.remove('plays');
});
const data = JSON.parse(byId('data').textContent);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const poses = new Float32Array(bytes(data.poses)), scans = new Uint16Array(bytes(data.scans));
const count = data.estimators.length, row = 3 + 7 * count, stops = data.ticks.length;
const still = matchMedia('(prefers-reduced-motion: reduce)');
const dark = matchMedia('(prefers-color-scheme: dark)');
const slider = byId('tick'), play = byId('play'), pace = byId('pace');
const cells = [...byId('readout').tBodies[0].rows].map((line) => line.cells);
const cursors = all('.cursor'), map = new MapView(byId('map')), inks = {};

// Poses are stored around the middle of the map.
const poseAt = (at, place) => {
  const [x, y, theta] = poses.subarray(at * row + place, at * row + place + 3);
  return [x + data.origin_m[0], y + data.origin_m[1], theta];
};
const partOf = (at, i) => ({
  pose: poseAt(at, 3 + 7 * i), ellipse: poses.subarray(at * row + 6 + 7 * i, at * row + 9 + 7 * i),
  nees: poses[at * row + 9 + 7 * i],
});
const estimators = data.estimators.map((of) => ({ ...of, isShown: true, track: new Track() }));
const jumps = data.jumps.map(([tick, text, x0, y0, x, y]) => ({ tick, text, from: [x0, y0], to: [x, y] }));

// Paths that grow to the tick that is shown, and whole ones.
let truthTrack = new Track(Infinity), tracked = 0;
const whole = new Track(Infinity);
function grow(at, truth, tracks) {
  if (jumps.some(({ tick }) => at > 0 && data.ticks[at - 1] < tick && tick <= data.ticks[at])) truth.cut();
  // A recording has a truth at its scans only: the path goes on between them.
  const [x, y] = poseAt(at, 0);
  if (Number.isFinite(x)) truth.add(x, y);
  // An estimate that moves farther than this was not driven: 5 m/s.
  const leap = Math.max(1, 5 * (data.times_s[at] - data.times_s[at - 1]));
  tracks.forEach((track, i) => {
    track.leap = leap;
    track.add(...partOf(at, i).pose);
  });
}
estimators.forEach((of) => { of.whole = new Track(); });
for (let at = 0; at < stops; at += 1) grow(at, whole, estimators.map((of) => of.whole));
function track(to) {
  if (tracked > to + 1) {
    [truthTrack, tracked] = [new Track(Infinity), 0];
    for (const of of estimators) of.track = new Track();
  }
  for (; tracked <= to; tracked += 1) grow(tracked, truthTrack, estimators.map((of) => of.track));
}

// The echoes of the latest scan, from the true pose at its tick.
function scanAt(at) {
  const k = data.scan_stops.findLastIndex((stop) => stop <= at), points = [];
  const [x, y, theta] = k < 0 ? [] : poseAt(data.scan_stops[k], 0);
  const c = Math.cos(theta), s = Math.sin(theta), [sx, sy, turn] = data.sensor_in_body;
  for (let beam = 0; k >= 0 && beam < data.beams; beam += 1) {
    const range = scans[k * data.beams + beam] * data.range_unit_m;
    const bearing = turn + data.first_bearing_rad + beam * data.bearing_step_rad;
    const u = sx + range * Math.cos(bearing), v = sy + range * Math.sin(bearing);
    if (range > 0) points.push(x + c * u - s * v, y + s * u + c * v);
  }
  return { points, tick: k < 0 ? -1 : data.ticks[data.scan_stops[k]] };
}

// The latest beliefs; those of a filter that is no estimator are always shown.
const beliefs = data.beliefs.map((of) => ({ ...of, bytes: new DataView(bytes(of.poses)) }));
const others = beliefs.filter((of) => of.estimator === null).map((of) => ({
  ...of, of, pose: [], ellipse: [], track: new Track(), isShown: true,
}));
function beliefAt(of, at) {
  const k = of.ticks.findLastIndex((tick) => tick <= data.ticks[at]);
  if (k < 0) return null;
  const [x0, y0, x1, y1] = data.bounds_m, found = [];
  for (let place = 0; place < of.marks; place += 1) {
    const from = 6 * (k * of.marks + place), share = of.bytes.getUint8(from + 5);
    if (share === 0) continue;
    found.push(x0 + (x1 - x0) * of.bytes.getUint16(from, true) / 65535,
      y0 + (y1 - y0) * of.bytes.getUint16(from + 2, true) / 65535,
      of.bytes.getUint8(from + 4) / 128 * Math.PI, share / 255);
  }
  return { kind: of.kinds[k] === 'cells' ? 2 : 1, poses: Float32Array.from(found), k };
}

function readInks() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['ink', 'soft', 'card', 'grid', 'truth', 'wall', 'glass', 'door', 'scan', 'rim']) {
    inks[name] = style.getPropertyValue(`--${name}`).trim();
  }
  for (const of of [...estimators, ...others]) of.ink = of.colours[dark.matches ? 1 : 0];
  show(shown);
}

const text = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');
const place = ([x, y]) => `at ${x.toFixed(2)}, ${y.toFixed(2)} m`;
let shown = Number(slider.defaultValue), begun = null, clock = 0, painted = 0;

function show(at) {
  shown = at;
  track(at);
  const truth = poseAt(at, 0), words = [];
  if (Number.isFinite(truth[0])) words.push(`Robot ${place(truth)}.`);
  estimators.forEach((of, i) => {
    const { pose, ellipse, nees } = partOf(at, i), [x, y, theta] = pose;
    Object.assign(of, { pose, ellipse, belief: null });
    const off = Math.atan2(Math.sin(theta - truth[2]), Math.cos(theta - truth[2])) * 180 / Math.PI;
    [text(Math.hypot(x - truth[0], y - truth[1]), 3), text(off, 2), text(nees, 2)]
      .forEach((value, k) => { cells[i][k + 1].textContent = value; });
    if (Number.isFinite(x)) words.push(`${of.name} ${place(pose)}.`);
  });
  const held = beliefs.map((of) => {
    const belief = beliefAt(of, at), owner = estimators[of.estimator] ?? others.find((o) => o.of === of);
    owner.belief = belief;
    return belief ? `${of.name}: ${of.kinds[belief.k]} ${of.whole[belief.k]}, tick ${of.ticks[belief.k]}`
      : `${of.name}: –`;
  });
  const scan = scanAt(at);
  if (scan.tick >= 0) words.push(`Scan of tick ${scan.tick}.`);
  if (held.length > 0) byId('beliefs').textContent = held.join(' · ');
  for (const jump of jumps) jump.isPast = jump.tick <= data.ticks[at];
  map.resize();
  map.draw({
    truth, truthTrack, whole, jumps, start: data.start, scan: scan.points, estimators: [...estimators, ...others],
  }, inks);
  map.canvas.setAttribute('aria-label', ['Map.', ...words].join(' '));
  const [from, to] = data.range_s, [left, right] = data.chart;
  const x = left + (data.times_s[at] - from) / (to - from) * (right - left);
  for (const cursor of cursors) {
    cursor.classList.remove('gone');
    cursor.setAttribute('transform', `matrix(1 0 0 1 ${x} 0)`);
  }
  const seconds = Math.round(data.times_s[at] * 100) / 100;
  const now = `tick ${data.ticks[at]}${data.is_in_ticks ? '' : ` · ${seconds.toFixed(2)} s`}`;
  byId('now').textContent = now;
  slider.value = at;
  slider.setAttribute('aria-valuetext', now);
}
const nearest = (list, value) => {
  let best = 0;
  list.forEach((v, k) => { if (Math.abs(v - value) < Math.abs(list[best] - value)) best = k; });
  return best;
};
const keep = () => history.replaceState(null, '', `#tick=${data.ticks[slider.value]}`);
const choose = (at) => { stop(); show(at); };

function paint(time) {
  if (begun === null) return;
  clock += Math.min(0.25, (time - begun) / 1000) * Number(pace.value);
  begun = time;
  const last = stops - 1;
  const next = data.times_s.findIndex((at) => at > clock);
  if (time - painted >= (still.matches ? 1000 : 0) || next < 0) {
    painted = time;
    show(next < 0 ? last : Math.max(0, next - 1));
  }
  if (next < 0) stop();
  else requestAnimationFrame(paint);
}
function start() {
  clock = data.times_s[shown >= stops - 1 ? 0 : shown];
  [begun, painted] = [performance.now(), 0];
  play.textContent = 'Pause';
  requestAnimationFrame(paint);
}
function stop() {
  begun = null;
  play.textContent = 'Play';
}
const toggle = () => (begun === null ? start() : stop());

// After the map was moved. One that shows all of the map leaves the finger to the page.
function redraw() {
  map.canvas.style.touchAction = map.isFitted ? 'pan-y' : 'none';
  if (begun === null) show(shown);
}

// A link to a tick.
function follow() {
  const asked = /^#tick=(\d+)$/.exec(location.hash);
  if (asked) choose(nearest(data.ticks, Number(asked[1])));
  return asked !== null;
}

// A chart chooses its time, by click or by dragging, which may leave it.
function listen(chart) {
  const point = (event) => {
    const box = chart.getBoundingClientRect(), [left, right] = data.chart, [from, to] = data.range_s;
    const at = (event.clientX - box.left) / box.width * chart.viewBox.baseVal.width;
    choose(nearest(data.times_s, from + (at - left) / (right - left) * (to - from)));
  };
  const end = () => {
    removeEventListener('pointermove', point);
    keep();
  };
  chart.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    point(event);
    keep();
    addEventListener('pointermove', point);
    for (const kind of ['pointerup', 'pointercancel']) addEventListener(kind, end, { once: true });
  });
}

function begin() {
  byId('control').hidden = false;
  document.body.classList.add('plays');
  map.setScene(data);
  const span = data.range_s[1] - data.range_s[0];
  const paces = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000];
  pace.append(...paces.map((value) => new Option(`${value}×`, value)));
  pace.value = paces.find((value) => value >= 1 && span / value <= MOST_PLAY_S) ?? 5000;
  play.addEventListener('click', toggle);
  slider.addEventListener('input', () => choose(Number(slider.value)));
  slider.addEventListener('change', keep);
  addEventListener('hashchange', follow);
  addEventListener('resize', () => show(shown));
  dark.addEventListener('change', readInks);
  map.listen(redraw, (event) => event.ctrlKey);
  for (const [id, move] of [['in', () => map.zoom(1.4)], ['out', () => map.zoom(1 / 1.4)], ['fit', () => map.fit()]]) {
    byId(id).addEventListener('click', () => { move(); redraw(); });
  }
  addEventListener('keydown', (event) => {
    const isControl = event.target.closest?.('button, select, input') || event.ctrlKey || event.altKey || event.metaKey;
    if (isControl || ![' ', '.'].includes(event.key)) return;
    event.preventDefault();
    if (event.key === ' ') toggle();
    else choose(Math.min(stops - 1, shown + 1));
  });
  all('svg.chart').forEach(listen);
  // A browser that goes back may set slider and boxes after this.
  addEventListener('pageshow', () => {
    all('.toggle').forEach((box, i) => apply(box, i));
    if (begun === null && !follow()) show(Number(slider.value));
  });
  readInks();
  // By itself once, from the beginning, for who came to look at the run and not at a tick.
  const isBack = performance.getEntriesByType('navigation')[0]?.type === 'back_forward';
  if (!follow() && !isBack && !still.matches && stops > 1) {
    show(0);
    start();
  }
}
// Who is shown.
function apply(box, i) {
  for (const part of all(`.e${i}`)) part.style.display = box.checked ? '' : 'none';
  estimators[i].isShown = box.checked;
}
all('.toggle').forEach((box, i) => {
  box.disabled = false;
  box.addEventListener('change', () => {
    apply(box, i);
    if (begun === null) show(shown);
  });
});
if (stops > 0) begin();
