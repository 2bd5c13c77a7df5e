// LiDAR anatomy: a scene, its scan as a strip of numbers, and one beam of it.

const CLIFF_M = 0.25, BEAMS_PER_S = 18, CLIFF_S = 2.5, LEFT_PX = 30, BOTTOM_PX = 18;
const core = new Core(), map = new MapView(byId('map'));
let inks = readInks(), state = null, exact = [], ranges = [], cliffs = [], wait = 0;

const opened = async (sets, seed) => {
  await core.open(changed(BASE, sets), seed);
  state = await core.advance(1);
  return (await core.call('scan')).numbers;
};

// One after the other, and of several that wait the last.
let generation = 0, opening = Promise.resolve();
function begin() {
  const mine = generation += 1;
  opening = opening.catch(() => {}).then(() => mine === generation && reopen());
  return opening;
}

async function reopen() {
  exact = await opened({ ...panel.sets, 'lidar.range_std_m': 0, 'lidar.dropout': 0 }, panel.seed);
  cliffs = [...exact.keys()].filter((k) => k > 0 && Math.abs(exact[k] - exact[k - 1]) > CLIFF_M);
  ranges = await opened(panel.sets, panel.seed);
  byId('cliffs').textContent = cliffs
    .map((k) => `beams ${k - 1} and ${k}, ${exact[k - 1].toFixed(3)} to ${exact[k].toFixed(3)} m`).join('; ');
  map.setScene({ ...SCENE, bounds_m: [1.5, 1, 8.3, 5.6] });
  player.seek(player.at);
}

// Positions are tenths of a second: a tick of the world each, and a walk along the beams.
async function show(at) {
  await opening;
  const mine = generation;
  const [next, scan] = [await core.advance(1 + at), await core.call('scan')];
  if (mine !== generation) return;
  [state, ranges] = [next, scan.numbers];
  if (player.isOn) walk();
  draw();
}

// The next beam; at a cliff it waits.
function walk() {
  if (wait-- > 0) return;
  const beam = byId('beam'), from = Number(beam.value);
  const to = from + Math.round(BEAMS_PER_S / player.rate);
  const cliff = cliffs.find((k) => from < k && k <= to);
  beam.value = cliff ?? to % SCENE.beams;
  if (cliff) {
    wait = CLIFF_S * player.rate;
    say(`Beam ${cliff - 1} reads ${exact[cliff - 1].toFixed(3)} m, beam ${cliff} reads ${exact[cliff].toFixed(3)} m: the beam passes an edge.`);
  }
  if (to >= SCENE.beams && panel.isTour) panel.begin(panel.stage + 1);
}

function draw() {
  if (!ranges.length) return;
  const k = Number(byId('beam').value), { start, sensor_in_body: at } = SCENE;
  const c = Math.cos(start.theta_rad), s = Math.sin(start.theta_rad);
  const origin = [start.x_m + c * at.x_m - s * at.y_m, start.y_m + s * at.x_m + c * at.y_m];
  const end = (i) => [0, 1].map((axis) => origin[axis]
    + ranges[i] * [Math.cos, Math.sin][axis](start.theta_rad + bearing(i)));
  map.resize();
  map.draw({
    truth: [start.x_m, start.y_m, start.theta_rad], truthTrack: new Track(), estimators: [],
    scan: [...ranges.keys()].flatMap(end),
  }, inks);
  const { ctx } = map;
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  for (const [i, ink, width] of [...ranges.keys()].map((i) => [i, inks.grid, 0.7]).concat([[k, inks.first, 3]])) {
    ctx.beginPath();
    ctx.moveTo(...map.place(...origin));
    ctx.lineTo(...map.place(...end(i)));
    Object.assign(ctx, { strokeStyle: ink, lineWidth: width * map.ratio });
    ctx.stroke();
  }
  ctx.setTransform(map.scale, 0, 0, -map.scale, ...map.place(0, 0));
  map.robot([start.x_m, start.y_m, start.theta_rad], inks);
  drawStrip(k);
  const jump = k > 0 ? ranges[k] - ranges[k - 1] : NaN;
  const texts = {
    number: k, bearing: `${(bearing(k) * 180 / Math.PI).toFixed(0)}°`, range: `${fixed(ranges[k], 3)} m`,
    exact: `${fixed(exact[k], 3)} m`, jump: `${jump > 0 ? '+' : ''}${fixed(jump, 3)} m`,
  };
  for (const [id, text] of Object.entries(texts)) byId(id).textContent = text;
  byId('beam').setAttribute('aria-valuetext', `beam ${k}, ${texts.range}`);
  byId('map').setAttribute('aria-label', `Robot in front of a doorway; beam ${k} reads ${texts.range}.`);
  panel.identify({
    ticks: state.ticks, dt_s: 0.02, digest: state.digest,
    command: commandLine(['launch', 'anatomy', '--seed', panel.seed, '--ticks', state.ticks, '--json'], panel.sets),
  });
}

// A bar for each beam, over the ranges without noise.
function drawStrip(k) {
  const canvas = byId('strip'), ratio = devicePixelRatio || 1, ctx = canvas.getContext('2d');
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  ctx.scale(ratio, ratio);
  const step = (width - LEFT_PX) / SCENE.beams, x = (i) => LEFT_PX + i * step;
  const y = (range) => 6 + (height - 6 - BOTTOM_PX) * (1 - range / SCENE.range_max_m);
  Object.assign(ctx, { font: '11px system-ui, "DejaVu Sans", sans-serif', textBaseline: 'middle', textAlign: 'right' });
  for (const metres of [0, 2, 4, 6, 8]) {
    ctx.fillStyle = inks.grid;
    ctx.fillRect(LEFT_PX, y(metres), width - LEFT_PX, 1);
    ctx.fillStyle = inks.soft;
    ctx.fillText(`${metres} m`, LEFT_PX - 4, y(metres));
  }
  ranges.forEach((range, i) => {
    ctx.fillStyle = i === k ? inks.first : range >= SCENE.range_max_m ? inks.soft : inks.second;
    ctx.globalAlpha = i === k ? 1 : 0.6;
    ctx.fillRect(x(i), y(range), Math.max(1, step - 0.5), y(0) - y(range));
  });
  ctx.globalAlpha = 1;
  ctx.beginPath();
  exact.forEach((range, i) => { ctx.lineTo(x(i), y(range)); ctx.lineTo(x(i + 1), y(range)); });
  Object.assign(ctx, { strokeStyle: inks.ink, lineWidth: 1 });
  ctx.setLineDash([3, 2]);
  ctx.stroke();
  ctx.textAlign = 'center';
  ctx.fillStyle = inks.ink;
  for (const cliff of cliffs) ctx.fillText(cliff, x(cliff), height - 6);
}

const player = new Player(show, () => {});
const panel = new Panel([{
  sets: { 'lidar.range_std_m': 0.02, 'lidar.dropout': 0 },
  text: 'A scan is a row of numbers. The wall is what you infer from them.',
}, {
  sets: { 'lidar.range_std_m': 0.02, 'lidar.dropout': 0.2 },
  text: 'A fifth of the beams reads 8 m: the largest number, with the least information.',
}], () => { begin().catch(complain); });
byId('beam').addEventListener('input', () => {
  panel.takeOver();
  player.play(false);
  draw();
});
byId('strip').addEventListener('pointerdown', ({ offsetX, target }) => {
  panel.takeOver();
  player.play(false);
  byId('beam').value = Math.floor((offsetX - LEFT_PX) / (target.clientWidth - LEFT_PX) * SCENE.beams);
  draw();
});
dark.addEventListener('change', () => { inks = readInks(); draw(); });
addEventListener('resize', draw);
panel.begin(0);
player.play(!still.matches);
globalThis.rustyWidget = { core, panel, player, get cliffs() { return cliffs; }, get ranges() { return ranges; } };
