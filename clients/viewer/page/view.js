// The page of a run or a log: the socket, what came, and what a person does with it.
// clients/viewer/src/record.rs has the table of the records, scene.rs the JSON.
import { MapView, Track, mark } from './draw.js';
import { Chart } from './charts.js';
import { Driver } from './drive.js';
import { drawSensors } from './sensors.js';

const byId = (id) => document.getElementById(id);
const HEAD = 11, EACH = 11; // words of a tick, and of an estimator in it
const MOST_ROWS = 6000; // of the charts; of a longer run every second one, and so on
const MOST_TRIES = 5; // to reach the viewer again
const still = matchMedia('(prefers-reduced-motion: reduce)');
const dark = matchMedia('(prefers-color-scheme: dark)');
const secret = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));

const map = new MapView(byId('map'));
let inks = {};
let scene = null, status = null;
let estimators = [];
let rows = [], shift = 0, seen = 0; // ticks for charts and paths: words of records
let now = null; // the words of the latest tick
let chosen = null; // the words of an earlier tick of a run, while it is looked at
let hovered = null;
let truthTrack = new Track(Infinity), tracked = 0, jumps = []; // jumps: kidnappings, for the map
let readings = { sonars: null, sectors: null }; // of the small sensors, the latest
let scan = null, bearings = []; // scan: the ranges of the latest, and the true pose at it
let digest = ''; // a text, or bytes
let isFollowing = false, isLog = false, mayDrive = false;
let isMapOld = true, areChartsOld = true;
let tries = 0, socket = null;
// For measurements.
const counts = { ticks: 0, gaps: 0, draws: 0, drawMs: 0, lastTick: -1, drawnTick: -1, firstMs: NaN };
globalThis.rustyView = counts;

const tickOf = (row) => row[1], timeOf = (row) => row[2], truthOf = (row) => row.subarray(3, 6);
const partOf = (row, i) => row.subarray(HEAD + EACH * i, HEAD + EACH * (i + 1));
const charts = [
  ['Position error, m', (row, i) => row[HEAD + EACH * i + 6]],
  ['Heading error, °', (row, i) => row[HEAD + EACH * i + 7] * 180 / Math.PI],
  ['NEES; 95 % of a consistent filter are below the dashed line', (row, i) => row[HEAD + EACH * i + 8], 7.815],
  ['Compute time, ms', (row, i) => row[HEAD + EACH * i + 9] * 1e3],
].map(([title, value, line]) => {
  const figure = document.createElement('figure'), canvas = document.createElement('canvas');
  const caption = document.createElement('figcaption');
  caption.textContent = title;
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `${title.split(';')[0]} of each estimator over time`);
  figure.append(caption, canvas);
  byId('charts').append(figure);
  return { chart: new Chart(canvas, value, line), canvas, figure, title, value };
});

const heads = byId('rows').parentElement.tHead.rows[0].cells;

function readInks() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['ink', 'soft', 'card', 'grid', 'truth', 'wall', 'glass', 'door', 'scan', 'rim']) {
    inks[name] = style.getPropertyValue(`--${name}`).trim();
  }
  for (const of of estimators) of.ink = of.colours[dark.matches ? 1 : 0];
  drawKeys();
  refresh();
}

// ---- What comes -------------------------------------------------------------------

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => socket.send(JSON.stringify(secret));
  socket.onmessage = ({ data }) => (typeof data === 'string' ? hear(JSON.parse(data)) : read(data));
  socket.onclose = () => {
    driver.stop();
    if (tries === Infinity) return;
    tries += 1;
    const isOver = tries > MOST_TRIES;
    say(isOver ? 'The viewer has ended. Load the page again if it is back.' : 'The connection is lost.');
    if (!isOver) setTimeout(connect, 1000);
  };
}
const ask = (request) => {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request));
};
const driver = new Driver(byId('drive'), byId('pad'), byId('map'), ask);
const say = (text) => { byId('state').textContent = text; };

function hear(message) {
  if (message.message === 'scene') setScene(message);
  if (message.message === 'status') setStatus(message);
  if (message.message === 'rights') { mayDrive = message.drive; tries = 0; showControls(); }
  if (message.message === 'refused') {
    tries = Infinity;
    say('This address does not have the right token. Use the one that the viewer printed.');
  }
}

function setScene(message) {
  scene = message;
  const hidden = new Set(estimators.filter((of) => !of.isShown).map((of) => of.name));
  estimators = scene.estimators.map((of) => ({
    ...of, isShown: !hidden.has(of.name), track: new Track(), belief: null,
    pose: [NaN, NaN, NaN], ellipse: [NaN, NaN, NaN],
  }));
  [rows, shift, seen, now, chosen, hovered] = [[], 0, 0, null, null, null];
  [truthTrack, tracked, jumps, scan, digest] = [new Track(Infinity), 0, [], null, scene.digest ?? ''];
  readings = { sonars: null, sectors: null };
  Object.assign(counts, { ticks: 0, gaps: 0, lastTick: -1, drawnTick: -1 });
  [drawnTicks, runTick] = [0, -1];
  bearings = Array.from({ length: scene.beams }, (_, k) => {
    const bearing = scene.sensor_in_body[2] + scene.first_bearing_rad + scene.fov_rad * k / scene.beams;
    return [Math.cos(bearing), Math.sin(bearing)];
  });
  document.title = scene.seed ? `${scene.scenario} · seed ${scene.seed}` : scene.scenario;
  byId('name').textContent = scene.scenario;
  byId('seed').textContent = scene.seed ?? 'none';
  byId('remark').textContent = scene.remark ?? '';
  byId('remark').hidden = !scene.remark;
  map.resize();
  map.setScene(scene);
  buildTable();
  readInks();
  if (scene.mode === 'log' && still.matches) ask({ do: 'pause' });
  showControls();
}

function setStatus(message) {
  status = message;
  const words = { waiting: 'Waiting.', running: 'Running.', paused: 'Paused.', ended: 'Ended.' };
  say(status.text || words[status.state]);
  const select = byId('pace'), pace = status.pace === null ? 'max' : String(status.pace);
  if (![...select.options].some((option) => option.value === pace)) {
    select.add(new Option(`${pace}×`, pace));
  }
  select.value = pace;
  showControls();
}

function showControls() {
  const isOver = !status || status.state === 'ended' || status.state === 'waiting';
  byId('play').textContent = status?.state === 'paused' ? 'Play' : 'Pause';
  for (const id of ['play', 'step', 'pace']) byId(id).disabled = isOver;
  byId('drive').hidden = !mayDrive || scene?.mode !== 'run' || isOver;
  if (byId('drive').hidden) driver.stop();
}

// Reads the records of a message.
function read(buffer) {
  const words = new Float64Array(buffer), whole = new Uint32Array(buffer);
  for (let at = 0; at < words.length;) {
    const [kind, length] = [whole[2 * at], whole[2 * at + 1]];
    if (kind === 2) readBelief(buffer, at, whole);
    else if (kind === 4) readReadings(buffer, at, whole);
    else readTick(buffer, at, words, whole, kind);
    at += Math.max(1, length);
  }
  refresh();
}

function readTick(buffer, at, words, whole, kind) {
  const end = HEAD + EACH * whole[2 * at + 16], beams = whole[2 * at + 17];
  const row = words.slice(at, at + end);
  if (kind === 3) { keep(row); return; }
  counts.ticks += 1;
  if (counts.lastTick >= 0 && tickOf(row) > counts.lastTick) {
    counts.gaps += tickOf(row) - counts.lastTick - 1;
  }
  counts.lastTick = tickOf(row);
  if (scene?.mode === 'run') {
    if (!now || tickOf(row) > tickOf(now)) keep(row);
    const [low, high] = whole.subarray(2 * at + 18, 2 * at + 20);
    if (low || high) digest = new Uint8Array(buffer, 8 * (at + 9), 16);
  }
  now = row;
  if (beams > 0) scan = [new Float32Array(buffer, 8 * (at + end), beams), truthOf(row)];
}

// Keeps a tick for charts and paths, and of a long run fewer of them.
function keep(row) {
  if (rows.length && tickOf(row) <= tickOf(rows[rows.length - 1])) return;
  if (seen++ % 2 ** shift === 0) rows.push(row);
  if (rows.length > MOST_ROWS) {
    rows = rows.filter((_, k) => k % 2 === 0);
    shift += 1;
    retrack();
  }
}

// The echoes of the latest scan in the world frame; without a true pose about the origin.
function echoes() {
  if (!scan) return [];
  const [ranges, at] = scan;
  let [x, y, theta] = at;
  if (!Number.isFinite(x)) [x, y, theta] = [0, 0, 0];
  const c = Math.cos(theta), s = Math.sin(theta), [sx, sy] = scene.sensor_in_body;
  const points = [];
  ranges.forEach((range, k) => {
    if (!(range > 0 && range < scene.range_max_m * (1 - 1e-6)) || !bearings[k]) return;
    const u = sx + range * bearings[k][0], v = sy + range * bearings[k][1];
    points.push(x + c * u - s * v, y + s * u + c * v);
  });
  return points;
}

function readBelief(buffer, at, whole) {
  const of = estimators[whole[2 * at + 4]];
  if (!of) return;
  const [kind, count] = [whole[2 * at + 5], whole[2 * at + 6]];
  of.belief = { kind, poses: new Float32Array(buffer.slice(8 * (at + 4), 8 * (at + 4) + 16 * count)) };
}

function readReadings(buffer, at, whole) {
  const [sectors, count] = whole.subarray(2 * at + 4, 2 * at + 6);
  if (sectors !== 0xFFFFFFFF) readings.sectors = sectors;
  if (count > 0) readings.sonars = new Float32Array(buffer, 8 * (at + 3), count);
}

// ---- What is shown ----------------------------------------------------------------

function retrack() {
  truthTrack = new Track(Infinity);
  for (const of of estimators) of.track = new Track();
  [tracked, jumps] = [0, []];
}

// The tick that map and table show.
const shownRow = () => chosen ?? now;

// Paths up to the tick that is shown.
function track(row) {
  if (tracked > 0 && tickOf(rows[tracked - 1]) > tickOf(row)) retrack();
  for (; tracked < rows.length && tickOf(rows[tracked]) <= tickOf(row); tracked += 1) {
    const before = rows[tracked - 1];
    if (before && scene.kidnapped_at.some((tick) => tickOf(before) < tick && tick <= tickOf(rows[tracked]))) {
      const [from, to] = [before, rows[tracked]].map((found) => truthOf(found).subarray(0, 2));
      truthTrack.cut();
      jumps.push({ from, to, text: `${Number(timeOf(before).toFixed(2))} s`, isPast: true });
    }
    // A recording has a truth at its scans only: the path goes on between them.
    const [x, y] = truthOf(rows[tracked]);
    if (Number.isFinite(x)) truthTrack.add(x, y);
    estimators.forEach((of, i) => of.track.add(...partOf(rows[tracked], i)));
  }
}

function drawMap() {
  const row = shownRow();
  map.resize();
  if (row) {
    track(row);
    estimators.forEach((of, i) => {
      const part = partOf(row, i);
      [of.pose, of.ellipse] = [part.subarray(0, 3), part.subarray(3, 6)];
    });
    const [x, y] = truthOf(row);
    if (isFollowing && Number.isFinite(x)) follow(x, y);
  }
  const truth = row ? truthOf(row) : [NaN, NaN, NaN];
  // Without a truth and a map, the scan has a frame of its own.
  const at = scene?.truth === false && scene.walls.length === 0 ? [0, 0, 0] : truth;
  const old = chosen !== null;
  map.draw({
    truth: at, truthTrack, jumps, scan: old ? [] : echoes(),
    estimators: old ? estimators.map((of) => ({ ...of, belief: null })) : estimators,
  }, inks);
  if (scene && !old) drawSensors(map, at, scene, readings, inks);
}

// Where no motion is wanted, what is shown jumps when the robot comes to its rim.
function follow(x, y) {
  const [u, v] = map.place(x, y), { width, height } = map.canvas;
  const isNear = Math.abs(u / width - 0.5) < 0.35 && Math.abs(v / height - 0.5) < 0.35;
  if (!(still.matches && isNear)) map.centre = [x, y];
  map.isFitted = false;
}

function drawCharts() {
  const row = hovered ?? shownRow();
  const to = rows.length ? Math.max(timeOf(rows[rows.length - 1]), 1) : 1;
  for (const [k, { chart, figure, title, value }] of charts.entries()) {
    // A log has no compute times; not every filter reports a covariance.
    const isEmpty = !/error/.test(title) && !rows.some((r) => estimators.some((_, i) => Number.isFinite(value(r, i))));
    // The columns of the table are those of the charts.
    for (const part of [figure, heads[k + 1], ...estimators.map((of) => of.cells[k])]) part.hidden = isEmpty;
    if (!isEmpty) chart.draw(rows, timeOf, estimators, { isLog, inks, to, cursor: row ? timeOf(row) : NaN });
  }
  if (row) showNumbers(row);
  const seek = byId('seek'), last = rows.length ? tickOf(rows[rows.length - 1]) : 0;
  if (Number(seek.max) !== last) seek.max = last;
  const shown = shownRow();
  if (shown && document.activeElement !== seek) seek.value = tickOf(shown);
  seek.setAttribute('aria-valuetext', `tick ${seek.value}`);
}

const text = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');

function showNumbers(row) {
  byId('tick').textContent = tickOf(row);
  byId('time').textContent = `${timeOf(row).toFixed(2)} s`;
  const hex = (byte) => byte.toString(16).padStart(2, '0');
  byId('digest').textContent = (typeof digest === 'string' ? digest : Array.from(digest, hex).join('')) || '–';
  const isPast = hovered || chosen;
  byId('at').textContent = isPast ? `At tick ${tickOf(row)}, ${timeOf(row).toFixed(2)} s` : 'Now';
  estimators.forEach((of, i) => {
    const [, , , , , , metres, heading, nees, seconds] = partOf(row, i);
    [text(metres, 3), text(heading * 180 / Math.PI, 2), text(nees, 2), text(seconds * 1e3, 3)]
      .forEach((words, k) => { of.cells[k].textContent = words; });
  });
  const [x, y, theta] = truthOf(row);
  const place = Number.isFinite(x)
    ? `Robot at ${x.toFixed(2)}, ${y.toFixed(2)} m, heading ${(theta * 180 / Math.PI).toFixed(0)} degrees.`
    : 'The true pose is not known.';
  const errors = estimators.map((of, i) => [of.name, partOf(row, i)[6]])
    .filter(([, metres]) => Number.isFinite(metres))
    .map(([name, metres]) => `${name} is off by ${metres.toFixed(2)} m.`);
  byId('map').setAttribute('aria-label', ['Map.', place, ...errors].join(' '));
}

function swatch(draw) {
  const canvas = document.createElement('canvas'), ratio = globalThis.devicePixelRatio || 1;
  canvas.className = 'swatch';
  canvas.setAttribute('aria-hidden', 'true');
  [canvas.width, canvas.height] = [22.4 * ratio, 17.6 * ratio];
  const ctx = canvas.getContext('2d');
  ctx.scale(ratio, ratio);
  draw(ctx);
  return canvas;
}
const dash = (ink, width) => (ctx) => {
  Object.assign(ctx, { strokeStyle: ink, lineWidth: width });
  ctx.beginPath();
  ctx.moveTo(1, 8.8);
  ctx.lineTo(21, 8.8);
  ctx.stroke();
};

function buildTable() {
  byId('rows').replaceChildren(...estimators.map((of) => {
    const row = document.createElement('tr'), head = document.createElement('th');
    const label = document.createElement('label'), box = document.createElement('input');
    Object.assign(box, { type: 'checkbox', checked: of.isShown });
    box.addEventListener('change', () => { of.isShown = box.checked; refresh(); });
    of.label = label;
    label.append(box, of.name);
    head.scope = 'row';
    head.append(label);
    of.cells = Array.from({ length: 4 }, () => document.createElement('td'));
    row.append(head, ...of.cells);
    return row;
  }));
}

// What stands for what: next to each name, and below the map.
function drawKeys() {
  estimators.forEach((of, i) => {
    of.label.querySelector('canvas')?.remove();
    of.label.querySelector('input').after(swatch((ctx) => {
      dash(of.ink, of.width)(ctx);
      mark(ctx, i, [11, 8.8], 4, of.ink, inks.card);
    }));
  });
  if (!scene) return;
  const has = (kind) => scene.walls.some((wall) => wall[4] === kind);
  const key = [
    [scene.truth, 'true path', dash(inks.truth, 5)],
    [scene.sonar, 'sonar', (ctx) => {
      ctx.strokeStyle = inks.scan;
      ctx.beginPath();
      ctx.arc(2, 8.8, 14, -0.5, 0.5);
      ctx.stroke();
    }],
    [scene.bumper, 'bumper in contact', dash(inks.scan, 5)],
    [true, 'scan', (ctx) => [3, 9, 15].forEach((x) => {
      for (const [size, ink] of [[5, inks.rim], [3, inks.scan]]) {
        ctx.fillStyle = ink;
        ctx.fillRect(x + 1.5 - size / 2, 8.8 - size / 2, size, size);
      }
    })],
    [has('glass'), 'glass', dash(inks.glass, 3)],
    [has('door'), 'door', dash(inks.door, 4)],
  ].filter(([isThere]) => isThere);
  byId('key').replaceChildren(...key.map(([, name, draw]) => {
    const item = document.createElement('li');
    item.append(swatch(draw), name);
    return item;
  }));
}

// The map with every frame of the screen, the rest ten times a second; less often while
// the ticks of a run come fast, because it may wait for the core, and once a second where
// no motion is wanted. Nothing is drawn again that has not changed.
let mapTime = 0, chartTime = 0, drawnTicks = 0, runTick = -1, isScheduled = false, timer = 0;
const SLACK_MS = 300; // for charts, which then share a frame with a map
function isFast(time) {
  const ticks = scene?.mode === 'run' && now && runTick >= 0 ? tickOf(now) - runTick : counts.ticks - drawnTicks;
  return ticks > 0.8 * Math.max(time - mapTime, 16);
}
function schedule() {
  if (isScheduled) return;
  isScheduled = true;
  requestAnimationFrame(paint);
}
function refresh() {
  isMapOld = areChartsOld = true;
  schedule();
}
function paint(time) {
  isScheduled = false;
  const isHasty = isFast(time);
  let [mapPause, chartPause] = isHasty ? [100, 2000] : [0, 100];
  if (still.matches) mapPause = chartPause = 1000;
  if (areChartsOld && time - chartTime >= chartPause) {
    drawCharts();
    [areChartsOld, chartTime] = [false, time];
  }
  if (isMapOld && time - mapTime >= mapPause) {
    const begun = performance.now();
    drawMap();
    counts.drawMs += performance.now() - begun;
    counts.drawnTick = now ? tickOf(shownRow()) : -1;
    counts.draws += 1;
    if (now && !(counts.firstMs > 0)) counts.firstMs = performance.now();
    [isMapOld, mapTime, drawnTicks, runTick] = [false, time, counts.ticks, now ? tickOf(now) : -1];
  }
  const waits = [isMapOld && mapPause + mapTime - time,
    areChartsOld && chartPause + chartTime - time + (isHasty ? SLACK_MS : 0)];
  const wait = Math.min(...waits.filter((left) => left !== false));
  clearTimeout(timer);
  if (wait < Infinity) timer = setTimeout(schedule, wait);
}
// What a person does shows at once.
const touch = () => { mapTime = chartTime = -1e4; refresh(); };

// ---- What a person does -----------------------------------------------------------

const togglePlay = () => ask({ do: status?.state === 'paused' ? 'resume' : 'pause' });
const stepOnce = () => ask({ do: 'step', ticks: 1 });
byId('play').addEventListener('click', togglePlay);
byId('step').addEventListener('click', stepOnce);
byId('pace').addEventListener('change', ({ target }) => {
  ask({ do: 'pace', factor: target.value === 'max' ? null : Number(target.value) });
});

// The row whose value is nearest to one; null without rows.
const nearestRow = (valueOf, value) => rows.reduce((best, row) => (
  best && Math.abs(valueOf(best) - value) <= Math.abs(valueOf(row) - value) ? best : row), null);

function goTo(tick) {
  if (scene?.mode === 'log') ask({ do: 'seek', tick });
  else if (rows.length) {
    const nearest = nearestRow(tickOf, tick);
    chosen = nearest === rows[rows.length - 1] ? null : nearest;
    byId('live').hidden = chosen === null;
  }
  touch();
}
byId('seek').addEventListener('input', ({ target }) => goTo(Number(target.value)));
byId('live').addEventListener('click', () => {
  chosen = null;
  byId('live').hidden = true;
  byId('play').focus();
  touch();
});

const press = (button, isOn) => button.setAttribute('aria-pressed', isOn);
function toggleFollow(isOn = !isFollowing) {
  isFollowing = isOn;
  press(byId('follow'), isOn);
  if (isOn && map.isFitted) map.zoom(1.8);
  touch();
}
function fit() { toggleFollow(false); map.fit(); touch(); }
function zoom(factor, x, y) { map.zoom(factor, x, y); touch(); }
function toggleLog() { isLog = !isLog; press(byId('log'), isLog); touch(); }
byId('follow').addEventListener('click', () => toggleFollow());
byId('fit').addEventListener('click', fit);
byId('in').addEventListener('click', () => zoom(1.4));
byId('out').addEventListener('click', () => zoom(1 / 1.4));
byId('log').addEventListener('click', toggleLog);

map.listen((isDragged) => {
  if (isDragged && isFollowing) toggleFollow(false);
  touch();
});

// A chart: values where the pointer is, and its tick on a click.
for (const { chart, canvas } of charts) {
  const rowAt = (event) => {
    return nearestRow(timeOf, chart.timeAt(event.offsetX));
  };
  canvas.addEventListener('pointermove', (event) => { hovered = rowAt(event); touch(); });
  canvas.addEventListener('pointerleave', () => { hovered = null; touch(); });
  canvas.addEventListener('click', (event) => {
    const row = rowAt(event);
    if (row) goTo(tickOf(row));
  });
}

// ---- Keys -------------------------------------------------------------------------

addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (driver.isOn) { driver.keyDown(event); return; }
  const isControl = event.target.closest?.('button, select, input');
  const actions = {
    ' ': isControl ? null : togglePlay, '.': stepOnce, f: () => toggleFollow(),
    '+': () => zoom(1.4), '-': () => zoom(1 / 1.4), 0: fit, l: toggleLog,
  };
  const action = actions[event.key.toLowerCase()];
  if (!action || event.target.closest?.('select')) return;
  event.preventDefault();
  action();
});
addEventListener('keyup', (event) => driver.keyUp(event));

dark.addEventListener('change', readInks);
addEventListener('resize', touch);
readInks();
connect();
