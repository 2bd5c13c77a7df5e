// The parts that all widgets share: the module in a worker, time, sliders, and the line
// that identifies a run.

const byId = (id) => document.getElementById(id);
const still = matchMedia('(prefers-reduced-motion: reduce)');
const dark = matchMedia('(prefers-color-scheme: dark)');
const MOST_SEED = 2n ** 64n - 1n;
// The scenario as its file has it, and what a page draws it with.
const { scenario: BASE, scene: SCENE } = JSON.parse(byId('scenario').textContent);
delete BASE.seed; // The page has its own.
const HOLD_MS = 4000; // at the end of a stage, before the next one

// ---- The module -------------------------------------------------------------------

class Core {
  constructor() {
    const code = new Blob([byId('worker').textContent], { type: 'text/javascript' });
    this.worker = new Worker(URL.createObjectURL(code));
    this.waiting = new Map();
    this.calls = 0;
    this.worker.onmessage = ({ data: { id, isOk, text, numbers } }) => {
      const { resolve, reject } = this.waiting.get(id);
      this.waiting.delete(id);
      if (isOk) resolve({ text, numbers });
      else reject(new Error(text));
    };
    this.worker.postMessage({ module: byId('module').textContent.trim() });
  }

  // Calls a function of the module; seeds are BigInt.
  call(name, args = [], input = undefined) {
    const id = this.calls++;
    this.worker.postMessage({ id, name, args, input });
    return new Promise((resolve, reject) => { this.waiting.set(id, { resolve, reject }); });
  }

  // Begins a run in the page's floor plan.
  open(scenario, seed, isKept = false) {
    const floor = { bounds: SCENE.bounds_m, walls: SCENE.walls };
    return this.call('begin', [seed, Number(isKept)], fields({ ...scenario, floor }));
  }

  // Rows of the new ticks, and number of ticks and run digest after the last.
  async advance(ticks) {
    const { text, numbers } = await this.call('advance', [ticks]);
    const [digest, , count] = text.split('\n');
    return { ticks: Number(count), digest, numbers };
  }
}

// ---- Scenarios and commands -------------------------------------------------------

// A line for each field, as the module reads them; its module `config` has the keys.
function fields(value, key = '') {
  return Object.entries(value).map(([name, field]) => (typeof field === 'object'
    ? fields(field, `${key}${name}.`) : `${key}${name}=${field}\n`)).join('');
}

// The names of the estimators, in roster order.
function estimators() {
  const all = (BASE.participant ?? []).filter(({ role }) => role === 'estimator');
  return all.length ? all.map(({ name }) => name) : ['dead-reckoning'];
}

// The bearing of beam `k` in the robot's frame.
const bearing = (k) => SCENE.sensor_in_body.theta_rad + SCENE.first_bearing_rad + SCENE.fov_rad * k / SCENE.beams;

// A scenario with changes, as `--set` makes them.
function changed(scenario, sets) {
  const whole = structuredClone(scenario);
  for (const [key, value] of Object.entries(sets)) {
    const parts = key.split('.'), last = parts.pop();
    const place = parts.reduce((at, part) => (at[part] ??= {}), whole);
    // The other fields are parameters of the kind that was there.
    if (last === 'kind') for (const name of Object.keys(place)) delete place[name];
    place[last] = value;
  }
  return whole;
}

function toml(value) {
  if (Array.isArray(value)) return `[${value.map(toml).join(', ')}]`;
  if (typeof value === 'string') return JSON.stringify(value);
  if (typeof value !== 'object') return Object.is(value, -0) ? '-0.0' : String(value);
  return `{ ${Object.entries(value).map(([key, field]) => `${key} = ${toml(field)}`).join(', ')} }`;
}

const quoted = (word) => (/^[\w=.,:/+-]+$/.test(word) ? word : `'${word}'`);

// The words after `sim-server`.
function commandLine(words, sets) {
  const changes = Object.entries(sets)
    .map(([key, value]) => `--set ${quoted(`${key}=${typeof value === 'string' ? value : toml(value)}`)}`);
  return ['sim-server', ...words, ...changes].join(' ');
}

// ---- The page ---------------------------------------------------------------------

const say = (text) => { byId('state').textContent = text; };
const complain = (error) => {
  byId('remark').textContent = `${error.message}.`;
  byId('remark').hidden = false;
};
// A command whose lines break between words only.
function showWords(id, command) {
  byId(id).replaceChildren(...command.split(' ').flatMap((word, k) => {
    const span = document.createElement('span');
    span.textContent = word;
    return k ? [' ', span] : [span];
  }));
}
const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');

function readInks() {
  const style = getComputedStyle(document.documentElement), inks = {};
  for (const name of ['ink', 'soft', 'card', 'grid', 'truth', 'wall', 'glass', 'door', 'scan', 'rim',
    'accent', 'first', 'second', 'third']) {
    inks[name] = style.getPropertyValue(`--${name}`).trim();
  }
  inks.estimators = [inks.first, inks.second, inks.third];
  return inks;
}

// Positions over time: `rate` a second, from 0 to `end`. `show` is called with the
// latest whole position, and not again before its promise is kept.
class Player {
  constructor(show, ended) {
    Object.assign(this, { show, ended, rate: 10, end: Infinity, at: 0, isOn: false });
    Object.assign(this, { isBusy: false, shown: -1, last: 0 });
    byId('play').addEventListener('click', () => this.play(!this.isOn));
    document.addEventListener('visibilitychange', () => { this.last = Infinity; });
    requestAnimationFrame((time) => this.frame(time));
  }

  play(isOn) {
    if (isOn && this.at >= this.end) this.at = 0;
    this.isOn = isOn;
    byId('play').textContent = isOn ? 'Pause' : 'Play';
  }

  seek(at) { [this.at, this.shown] = [at, -1]; }

  async frame(time) {
    requestAnimationFrame((next) => this.frame(next));
    if (this.isBusy) return;
    // A page that was hidden goes on where it was.
    const seconds = Math.min(0.5, Math.max(0, (time - this.last) / 1000));
    this.last = time;
    if (this.isOn) this.at = Math.min(this.end, this.at + seconds * this.rate);
    const at = Math.floor(this.at);
    if (at === this.shown) return;
    [this.isBusy, this.shown] = [true, at];
    try {
      await this.show(at);
      if (this.isOn && at >= this.end) { this.play(false); this.ended(); }
    } catch (error) { this.play(false); complain(error); }
    this.isBusy = false;
  }
}

// Seed, sliders, buttons, keys, and the tour of settings that runs until a reader takes
// over. `changedTo(isNewRun)` is called after every change.
class Panel {
  constructor(stages, changedTo) {
    Object.assign(this, { stages, changedTo, stage: 0, isTour: !still.matches });
    this.sliders = [...document.querySelectorAll('input[data-key]')];
    for (const slider of this.sliders) {
      slider.addEventListener('input', () => { this.takeOver(); this.showValues(); changedTo(false); });
    }
    byId('seed').addEventListener('change', () => {
      const text = byId('seed').value.trim();
      const isSeed = /^\d{1,20}$/.test(text) && BigInt(text) <= MOST_SEED;
      byId('seed').setAttribute('aria-invalid', !isSeed);
      say(isSeed ? '' : `A seed is a whole number from 0 to ${MOST_SEED}.`);
      if (isSeed) { this.takeOver(); changedTo(true); }
    });
    byId('copy').addEventListener('click', async () => {
      await navigator.clipboard.writeText(byId('command').textContent).then(
        () => say('The command is copied.'), () => getSelection().selectAllChildren(byId('command')));
    });
    document.body.addEventListener('keydown', (event) => {
      const isField = event.target.matches('input:not([type=range]), select, button, summary');
      if (event.code === 'Space' && !isField && !event.defaultPrevented) {
        byId('play').click();
        event.preventDefault();
      }
    });
    this.showValues();
  }

  get seed() { return BigInt(byId('seed').value.trim()); }

  // The value of each slider by its key.
  get sets() {
    return Object.fromEntries(this.sliders.map((one) => [one.dataset.key, Number(one.value)]));
  }

  showValues() {
    for (const slider of this.sliders) {
      const { scale = 1, digits = 3, unit = '' } = slider.dataset;
      const text = `${(slider.value * scale).toFixed(digits)}${unit}`;
      slider.nextElementSibling.textContent = text;
      slider.setAttribute('aria-valuetext', text);
    }
  }

  takeOver() {
    this.isTour = false;
    clearTimeout(this.timer);
  }

  // Sets the sliders to a stage of the tour.
  begin(stage) {
    this.stage = stage % this.stages.length;
    const { sets, text } = this.stages[this.stage];
    for (const slider of this.sliders) {
      if (slider.dataset.key in sets) slider.value = sets[slider.dataset.key];
    }
    this.showValues();
    say(text);
    this.changedTo(true);
  }

  // After a pause the next stage, unless a reader took over.
  next() {
    if (this.isTour) this.timer = setTimeout(() => this.begin(this.stage + 1), HOLD_MS);
  }

  identify({ ticks, dt_s, digest, command }) {
    byId('tick').textContent = ticks;
    byId('time').textContent = `${(ticks * dt_s).toFixed(2)} s`;
    byId('digest').textContent = digest;
    showWords('command', command);
  }
}
