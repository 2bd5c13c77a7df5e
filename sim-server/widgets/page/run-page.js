// A run on a map with its errors over time: the dashboard and the filters.
// The module's page `run` has the words of a row.

const HEAD = 9, EACH = 9;

class RunPage {
  // `launch`: words of the command; `fixed`: changes that stay; `rate`: ticks a second.
  constructor({ launch, fixed: sets, rate, ticks, stages }) {
    Object.assign(this, { launch, sets, ticks, kidnappings: [] });
    this.dt_s = sets.dt_s ?? BASE.dt_s;
    this.scanEvery = sets.scan_every ?? BASE.scan_every;
    this.names = estimators();
    this.core = new Core();
    this.map = new MapView(byId('map'));
    this.inks = readInks();
    this.isDriven = false;
    this.reset();
    this.charts = [['error', 6], ['heading', 7]].map(([id, word]) => {
      const unit = id === 'heading' ? 180 / Math.PI : 1;
      return new Chart(byId(id), (row, i) => row[HEAD + EACH * i + word] * unit);
    });
    this.player = new Player((at) => this.show(at), () => this.panel.next());
    this.player.rate = rate;
    this.panel = new Panel(stages, (isNew) => this.begin(isNew).catch(complain));
    byId('restart').addEventListener('click', () => {
      this.panel.takeOver();
      this.begin(true).catch(complain);
    });
    dark.addEventListener('change', () => { this.inks = readInks(); this.draw(); });
    addEventListener('resize', () => this.draw());
    this.panel.begin(0);
    this.player.play(!still.matches);
  }

  reset() {
    Object.assign(this, { rows: [], ranges: [], beliefs: [], state: null, truthTrack: new Track() });
    this.tracks = [];
  }

  get scenario() {
    const own = this.kidnappings.length ? { kidnapping: this.kidnappings } : {};
    return { ...this.sets, ...this.panel.sets, ...own };
  }

  // Opens the run anew. With other settings it goes on at the tick where it was: a run is
  // a function of seed, settings and commands, so all ticks before are simulated again.
  async begin(isNew) {
    if (isNew) {
      this.kidnappings = structuredClone(BASE.kidnapping ?? []);
      this.setDriven(false);
    }
    this.at = isNew ? 0 : this.player.at;
    this.player.end = this.isDriven ? Infinity : this.ticks;
    const generation = this.generation = (this.generation ?? 0) + 1;
    this.opening = this.core.open(changed(BASE, this.scenario), this.panel.seed, this.isDriven && !isNew);
    await this.opening;
    if (generation !== this.generation) return;
    this.reset();
    this.map.resize();
    this.map.setScene(SCENE);
    this.tracks = this.names.map(() => new Track());
    this.player.seek(Math.max(1, this.at));
    byId('remark').hidden = true;
  }

  setDriven(isDriven) {
    this.isDriven = isDriven;
    if (byId('save')) byId('save').hidden = !isDriven;
  }

  async show(at) {
    await this.opening;
    if (this.state && at < this.state.ticks) { await this.begin(true); return; }
    const width = HEAD + EACH * this.names.length;
    const { generation } = this;
    const state = await this.core.advance(Math.max(1, at));
    const [scan, ...beliefs] = await Promise.all([this.core.call('scan'),
      ...this.names.map((_, i) => this.core.call('belief', [i]))]);
    if (generation !== this.generation) return;
    for (let k = 0; k < state.numbers.length; k += width) {
      const row = state.numbers.subarray(k, k + width);
      this.rows.push(row);
      this.truthTrack.add(row[2], row[3]);
      this.tracks.forEach((track, i) => track.add(row[HEAD + EACH * i], row[HEAD + EACH * i + 1]));
    }
    [this.state, this.ranges, this.beliefs] = [state, scan.numbers, beliefs.map((of) => of.numbers)];
    this.draw();
  }

  // The echoes of the latest scan, seen from the true pose at its tick.
  echoes() {
    const tick = this.rows.length - 1, [x, y, theta] = this.rows[tick - tick % this.scanEvery].subarray(2, 5);
    const points = [], { sensor_in_body: at, range_max_m } = SCENE;
    const c = Math.cos(theta), s = Math.sin(theta);
    this.ranges.forEach((range, k) => {
      if (range >= range_max_m) return;
      const angle = bearing(k), u = at.x_m + range * Math.cos(angle), v = at.y_m + range * Math.sin(angle);
      points.push(x + c * u - s * v, y + s * u + c * v);
    });
    return points;
  }

  // The kidnappings up to now, as arrows.
  jumps() {
    const past = this.kidnappings.filter(({ tick }) => tick > 0 && tick < this.rows.length);
    return past.map(({ tick, to }) => ({
      from: [...this.rows[tick - 1].subarray(2, 4)], to: [to.x_m, to.y_m],
      text: `${(tick * this.dt_s).toFixed(1)} s`, isPast: true,
    }));
  }

  draw() {
    const row = this.rows.at(-1);
    if (!row) return;
    const { inks, map } = this;
    this.estimators = this.names.map((name, i) => {
      const part = row.subarray(HEAD + EACH * i, HEAD + EACH * (i + 1));
      return {
        name, isShown: true, ink: inks.estimators[i], width: 3 - 0.6 * i, track: this.tracks[i],
        pose: part.subarray(0, 3), ellipse: part.subarray(3, 6), errors: part.subarray(6),
        belief: this.beliefs[i]?.length ? { kind: 1, poses: this.beliefs[i] } : null,
      };
    });
    map.resize();
    map.draw({
      truth: row.subarray(2, 5), truthTrack: this.truthTrack, scan: this.echoes(),
      estimators: this.estimators, jumps: this.jumps(),
    }, inks);
    const to = Math.max(this.ticks * this.dt_s, row[1]);
    for (const chart of this.charts) {
      chart.draw(this.rows, (of) => of[1], this.estimators, { isLog: false, cursor: NaN, inks, to });
    }
    this.panel.identify({
      ticks: this.state.ticks, dt_s: this.dt_s, digest: this.state.digest, command: this.command,
    });
    this.showNumbers(row);
  }

  get command() {
    const seed = ['--seed', this.panel.seed, '--ticks', this.state?.ticks ?? 0, '--json'];
    if (this.isDriven) return commandLine(['launch', 'widget.toml', ...seed], {});
    const [scenario, ...more] = this.launch;
    return commandLine(['launch', scenario, ...more, ...seed], this.scenario);
  }

  showNumbers(row) {
    const cells = this.estimators.map(({ name, ink, errors }) => {
      const line = document.createElement('tr'), head = document.createElement('th');
      head.scope = 'row';
      head.textContent = name;
      head.style.borderLeft = `.4rem solid ${ink}`;
      line.append(head, ...[fixed(errors[0], 3), fixed(errors[1] * 180 / Math.PI, 2), errors[2] > 1e4 ? errors[2].toExponential(0) : fixed(errors[2], 1)]
        .map((text) => Object.assign(document.createElement('td'), { textContent: text })));
      return line;
    });
    byId('rows').replaceChildren(...cells);
    byId('driven').textContent = `${row[7].toFixed(2)} m`;
    const drift = this.estimators[0].errors[0] / row[7];
    byId('drift').textContent = row[7] > 0 ? `${(100 * drift).toFixed(1)} %` : '–';
    byId('wall').hidden = row[8] === 0;
    byId('map').setAttribute('aria-label', [
      `Map. Robot at ${row[2].toFixed(2)}, ${row[3].toFixed(2)} m.`,
      ...this.estimators.map(({ name, errors }) => (Number.isFinite(errors[0])
        ? `${name} is off by ${errors[0].toFixed(2)} m.` : `${name} gives no answer.`)),
    ].join(' '));
  }

  // Saves a scenario with all commands up to now: the run again without a person.
  async save() {
    const { numbers } = await this.core.call('commands');
    const list = Array.from({ length: numbers.length / 2 }, (_, k) => (
      { v_m_s: numbers[2 * k], omega_rad_s: numbers[2 * k + 1] }));
    const whole = changed(BASE, { ...this.scenario, 'script.kind': 'commands', 'script.list': list });
    const text = Object.entries(whole)
      .map(([key, value]) => `${key} = ${toml(value)}\n`).join('');
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([text], { type: 'application/toml' }));
    link.download = 'widget.toml';
    link.click();
  }

  drive(v, omega) {
    this.panel.takeOver();
    this.setDriven(true);
    this.player.end = Infinity;
    if (!this.player.isOn) this.player.play(true);
    return this.core.call('drive', [v, omega]).catch(complain);
  }

  async kidnap(to) {
    this.panel.takeOver();
    try {
      const tick = Number((await this.core.call('kidnap', [to.x_m, to.y_m, to.theta_rad])).text);
      this.kidnappings = [...this.kidnappings.filter((one) => one.tick < tick), { tick, to }];
      this.player.end = Math.max(this.player.end, tick + this.ticks / 2);
      this.player.play(true);
    } catch (error) { complain(error); }
  }
}
