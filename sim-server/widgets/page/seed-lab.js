// The Seed Lab: many runs that differ in their seed alone.

const FIGURES = 12, EACH = 6, CHUNK = 100, TICKS = 30;
const FIXED = { dt_s: 0.1 };
const base = { ...BASE, ticks: TICKS };
const core = new Core(), map = new MapView(byId('fan'));
let inks = readInks(), runs = [], rows = [], chosen = 0, generation = 0;
byId('seed').value = 0;
const chart = new Chart(byId('growth'), (row, i) => row[i + 1]);

// Where run `run` truly is after `tick` ticks, from the nominal place; `part` 3 is nominal.
const at = (run, tick, part = 0) => (tick === 0 ? [0, 0]
  : run.path.subarray((tick - 1) * EACH + part, (tick - 1) * EACH + part + 2));
const sets = () => ({ ...FIXED, ...panel.sets });

// Makes the runs of `count` seeds. Resolves to their figures, paths and digests.
async function table(scenario, first, count, progress) {
  await core.open(scenario, first);
  const made = [], width = FIGURES + EACH * scenario.ticks;
  for (let done = 0; done < count; done += CHUNK) {
    const size = Math.min(CHUNK, count - done);
    const { text, numbers } = await core.call('lab', [first + BigInt(done), size]);
    text.split('\n').forEach((digest, k) => {
      const words = numbers.subarray(k * width, (k + 1) * width);
      made.push({
        seed: first + BigInt(done + k), digest, figures: words.subarray(0, FIGURES), path: words.subarray(FIGURES),
      });
    });
    if (progress(done + size) === false) return null;
  }
  return made;
}

async function begin(isNew) {
  const mine = generation += 1, count = Number(byId('count').value);
  const progress = (done) => {
    if (done < count) byId('tick').textContent = `${done} of ${count} runs`;
    return mine === generation;
  };
  const made = await table(changed(base, sets()), panel.seed, count, progress);
  if (!made) return;
  [runs, chosen] = [made, 0];
  const far = Math.max(0.25, ...runs.flatMap((run) => [...run.path.keys()].filter((k) => k % EACH === 1).map((k) => Math.abs(run.path[k]))));
  map.setScene({ bounds_m: [0, -far, 1.5, far], walls: [], body_radius_m: 0.11 });
  rows = Array.from({ length: TICKS }, (_, k) => spread(k + 1));
  byId('remark').hidden = true;
  showTable();
  if (isNew) player.at = 0;
  player.seek(player.at);
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
const deviation = (values) => {
  const middle = mean(values);
  return Math.sqrt(values.reduce((sum, v) => sum + (v - middle) ** 2, 0) / (values.length - 1));
};

// Time; total spread, spread along, mean offset, cm; spread across, cm.
function spread(tick) {
  const off = [0, 1].map((axis) => runs.map((run) => 100 * (at(run, tick)[axis] - at(run, tick, 3)[axis])));
  const [along, across] = off.map(deviation);
  return [tick * FIXED.dt_s, Math.hypot(along, across), along, Math.hypot(...off.map(mean)), across];
}

// The slope of the total spread in logarithms, from half a second on.
function exponent() {
  const points = rows.filter(([t, total]) => t >= 0.5 - 1e-9 && total > 1e-4).map(([t, total]) => [Math.log(t), Math.log(total)]);
  const [x, y] = [0, 1].map((axis) => mean(points.map((point) => point[axis])));
  const sum = (of) => points.reduce((all, [u, v]) => all + (u - x) * (of ? v - y : u - x), 0);
  return points.length > 2 ? sum(true) / sum(false) : NaN;
}

function showTable() {
  byId('runs').replaceChildren(...runs.map(({ seed, figures, digest }, k) => {
    const line = document.createElement('tr'), pick = document.createElement('button');
    Object.assign(pick, { type: 'button', textContent: seed });
    pick.addEventListener('click', () => { panel.takeOver(); chosen = k; draw(); });
    const cells = [pick, fixed(figures[3], 4), fixed(figures[4] * 180 / Math.PI, 2), `${digest.slice(0, 16)}…`];
    line.append(...cells.map((content) => {
      const cell = document.createElement('td');
      cell.append(content);
      return cell;
    }));
    return line;
  }));
  const last = rows.at(-1), second = (t) => rows[Math.round(t / FIXED.dt_s) - 1];
  for (const t of [1, 2, 3]) byId(`at-${t}`).textContent = `${fixed(second(t)[1], 1)} cm`;
  byId('ratio').textContent = last[2] > 1e-4 ? fixed(last[4] / last[2], 1) : '–';
  byId('exponent').textContent = fixed(exponent(), 2);
  byId('offset').textContent = `${fixed(last[3], 1)} cm`;
  const to = panel.seed + BigInt(runs.length);
  showWords('sweep', commandLine(['sweep', 'seed-lab', '--seeds', `${panel.seed}..${to}`, '--ticks', TICKS, '--out', 'lab.csv'], sets()));
}

function draw() {
  if (!runs.length) return;
  const tick = Math.min(TICKS, Math.max(1, Math.floor(player.at)));
  map.resize();
  const { ctx, ratio } = map;
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  ctx.clearRect(0, 0, map.canvas.width, map.canvas.height);
  Object.assign(ctx, { lineJoin: 'round', lineCap: 'round' });
  const line = (run, to, part, ink, width) => {
    ctx.beginPath();
    for (let k = 0; k <= to; k += 1) ctx.lineTo(...map.place(...at(run, k, part)));
    Object.assign(ctx, { strokeStyle: ink, lineWidth: width * ratio });
    ctx.stroke();
  };
  ctx.globalAlpha = runs.length > 100 ? 0.15 : 0.5;
  for (const run of runs) line(run, tick, 0, inks.first, 1.2);
  ctx.globalAlpha = 1;
  line(runs[chosen], tick, 0, inks.ink, 2.5);
  ctx.setLineDash([6 * ratio, 6 * ratio]);
  line(runs[0], TICKS, 3, inks.soft, 2);
  ctx.setLineDash([]);
  ctx.fillStyle = inks.second;
  for (const run of runs) {
    ctx.beginPath();
    ctx.arc(...map.place(...at(run, tick)), 2.5 * ratio, 0, 2 * Math.PI);
    ctx.fill();
  }
  const estimators = [0, 1, 2].map((i) => ({ isShown: true, ink: inks.estimators[i] }));
  chart.draw(rows, ([t]) => t, estimators, { isLog: false, inks, to: TICKS * FIXED.dt_s, cursor: tick * FIXED.dt_s });
  const { seed, digest } = runs[chosen];
  panel.identify({
    ticks: tick, dt_s: FIXED.dt_s, digest,
    command: commandLine(['launch', 'seed-lab', '--seed', seed, '--ticks', TICKS, '--json'], sets()),
  });
  [...byId('runs').rows].forEach((row, k) => row.setAttribute('aria-selected', k === chosen));
  const [, total, , offset] = rows[tick - 1];
  map.canvas.setAttribute('aria-label', `Paths of ${runs.length} seeds after ${(tick * FIXED.dt_s).toFixed(1)} s: `
    + `spread ${total.toFixed(1)} cm, mean offset ${offset.toFixed(1)} cm.`);
}

const player = new Player(draw, () => panel.next());
player.end = TICKS;
const panel = new Panel([{
  sets: { 'robot.slip_std': 0.05, 'robot.radius_bias_right': 0 },
  text: 'Slip alone: the same robot, the same commands. The fan is centred on the dashed line, and its width grows faster than time.',
}, {
  sets: { 'robot.slip_std': 0, 'robot.radius_bias_right': 0.01 },
  text: 'A wheel that is 1 % larger: all runs leave together. No number of seeds averages that away.',
}, {
  sets: { 'robot.slip_std': 0.05, 'robot.radius_bias_right': 0.01 },
  text: 'Both: bias moves the middle of the fan, slip makes it wide.',
}], (isNew) => { begin(isNew).catch(complain); });
byId('count').addEventListener('change', () => { panel.takeOver(); begin(false).catch(complain); });
dark.addEventListener('change', () => { inks = readInks(); draw(); });
addEventListener('resize', draw);
panel.begin(0);
if (still.matches) player.at = TICKS;
player.play(!still.matches);
globalThis.rustyWidget = { core, base, panel, player, table, changed, get runs() { return runs; } };
