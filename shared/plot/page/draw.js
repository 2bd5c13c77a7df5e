// The map: walls, paths, robot, scan, ellipses and beliefs on a canvas. It knows no
// socket and no page: the viewer and the report of a run draw with it. Metres and
// radians, world frame.

// Corners of the marks of estimators, as in the report; the first is a disc.
const SHAPES = [
  null,
  [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
  [[0, -1.25], [1.15, 0.8], [-1.15, 0.8]],
  [[0, -1.3], [1, 0], [0, 1.3], [-1, 0]],
  [[0, 1.25], [1.15, -0.8], [-1.15, -0.8]],
  [[-0.4, -1.2], [0.4, -1.2], [0.4, -0.4], [1.2, -0.4], [1.2, 0.4], [0.4, 0.4],
    [0.4, 1.2], [-0.4, 1.2], [-0.4, 0.4], [-1.2, 0.4], [-1.2, -0.4], [-0.4, -0.4]],
];
const COLOURS = 6;
// Corners of an arrowhead that looks along x, as in the pictures of a run.
const ARROWHEAD = [[1, 0], [-0.8, 0.62], [-0.8, -0.62]];
const FADED = 0.25; // what is yet to come

// Draws the mark of estimator `index` at a place of the canvas.
export function mark(ctx, index, [x, y], size, ink, rim) {
  const shape = SHAPES[(index + Math.floor(index / COLOURS)) % SHAPES.length];
  for (const [extra, fill] of [[1.5, rim], [0, ink]]) {
    ctx.beginPath();
    if (!shape) ctx.arc(x, y, size + extra, 0, 2 * Math.PI);
    else shape.forEach(([u, v]) => ctx.lineTo(x + (size + extra) * u, y + (size + extra) * v));
    ctx.fillStyle = fill;
    ctx.fill();
  }
}

// Points of a path up to which it is drawn anew as a whole, so that its picture does not
// depend on how it grew. Of longer ones what is new is added, which takes less time.
const MOST_REDRAWN = 1000;

// A path that grows. Points that are close to the last one are left out, and one that is
// farther than `leap` metres does not continue it.
export class Track {
  constructor(leap = 1) {
    Object.assign(this, { path: new Path2D(), news: null, points: 0, last: null, leap });
  }

  add(x, y) {
    if (!Number.isFinite(x + y)) { this.last = null; return; }
    const moved = this.last ? Math.hypot(x - this.last[0], y - this.last[1]) : Infinity;
    if (moved < 0.02) return;
    const goesOn = this.last && moved <= this.leap;
    if (!this.news) {
      this.news = new Path2D();
      if (goesOn) this.news.moveTo(...this.last);
    }
    for (const path of [this.path, this.news]) {
      if (goesOn) path.lineTo(x, y);
      else path.moveTo(x, y);
    }
    this.last = [x, y];
    this.points += 1;
  }

  // The next point does not continue the path.
  cut() { this.last = null; }

  // The part that was added since the last call; null without any.
  takeNews() {
    const { news } = this;
    this.news = null;
    return news;
  }
}

// A separate canvas that is drawn anew only where the view of the map or what is on it has
// changed: long paths and many walls take longer to draw than all the rest of a map.
class Layer {
  constructor() {
    this.canvas = document.createElement('canvas');
    Object.assign(this, { ctx: this.canvas.getContext('2d'), view: '', parts: [] });
  }

  // Puts it on the map. `parts` and `inks` are what it shows; `draw` is told whether that
  // is on it already.
  show({ canvas, ctx: to, centre, scale, ratio }, parts, inks, draw) {
    const { ctx } = this, { width, height } = canvas;
    const view = [width, height, ratio, scale, ...centre, ...inks].join();
    const isOld = view === this.view && parts.every((part, k) => part === this.parts[k]);
    if (!isOld) {
      // Also clears it.
      [this.canvas.width, this.canvas.height] = [width, height];
      [this.view, this.parts] = [view, parts];
      ctx.setTransform(to.getTransform());
      ctx.lineJoin = ctx.lineCap = 'round';
    }
    const stroke = (path, ink, pixels) => {
      ctx.strokeStyle = ink;
      ctx.lineWidth = pixels * ratio / scale;
      ctx.stroke(path);
    };
    draw(isOld, stroke);
    to.save();
    to.setTransform(1, 0, 0, 1, 0, 0);
    to.drawImage(this.canvas, 0, 0);
    to.restore();
  }

  // Draws paths, or adds what is new of long ones: [{ track, ink, width }], with widths in
  // pixels.
  paths(map, lines) {
    const inks = lines.flatMap(({ ink, width }) => [ink, width]);
    const parts = lines.flatMap(({ track }) => [track, Math.min(track.points, MOST_REDRAWN)]);
    this.show(map, parts, inks, (isOld, stroke) => {
      for (const { track, ink, width } of lines) {
        const news = track.takeNews(), path = isOld ? news : track.path;
        if (path) stroke(path, ink, width);
      }
    });
  }
}

// Corners of the bars of a histogram along a corridor, up for one heading
// and down for the other; null where the cells are not in a line. The scorer has the
// same, clients/scorer/src/scoring/bars.rs.
function barsOf(poses, greatest) {
  const places = Array.from({ length: poses.length / 4 }, (_, k) => 4 * k);
  const faces = (k, theta) => Math.cos(poses[k + 2] - theta) > 0;
  const last = places.findLast((k) => k > 0 && faces(k, poses[2]));
  const [dx, dy] = last ? [poses[last] - poses[0], poses[last + 1] - poses[1]] : [0, 0];
  const length = Math.hypot(dx, dy) * (dx < 0 || (dx === 0 && dy < 0) ? -1 : 1);
  if (!length || !(greatest > 0)) return null;
  const [c, s] = [dx / length, dy / length], axis = Math.atan2(s, c);
  const cells = places.map((k) => ({
    along: c * poses[k] + s * poses[k + 1], across: c * poses[k + 1] - s * poses[k],
    up: faces(k, axis) ? 1 : -1, share: poses[k + 3] / greatest,
    isParallel: Math.abs(Math.sin(poses[k + 2] - axis)) < 0.5,
  }));
  const rows = [1, -1].map((up) => cells.filter((cell) => cell.up === up).map((cell) => cell.across))
    .filter((row) => row.length > 0);
  const least = rows.map((row) => row.reduce((a, b) => Math.min(a, b)));
  const isStraight = rows.every((row, k) => row.every((across) => across - least[k] < 0.05));
  if (!isStraight || !cells.every((cell) => cell.isParallel)) return null;
  const middle = least.reduce((a, b) => a + b) / least.length;
  let gap = 1;
  cells.forEach((cell, k) => {
    const before = cells[k - 1], far = Math.abs(cell.along - before?.along);
    if (before?.up === cell.up && far > 1e-3) gap = Math.min(gap, far);
  });
  const half = 0.425 * gap;
  return cells.map(({ along, up, share }) => (
    [[-half, 0], [half, 0], [half, up * share], [-half, up * share]].map(([u, v]) => (
      [c * (along + u) - s * (middle + v), s * (along + u) + c * (middle + v)]))));
}

export class MapView {
  constructor(canvas) {
    this.canvas = canvas;
    this.ctx = canvas.getContext('2d');
    this.centre = [0, 0];
    this.scale = 50;
    this.ratio = 1;
    this.isFitted = true;
    [this.base, this.truthPath, this.paths] = [new Layer(), new Layer(), new Layer()];
    this.setScene({ bounds_m: [0, 0, 1, 1], walls: [], body_radius_m: 0.2 });
  }

  setScene(scene) {
    this.scene = scene;
    this.walls = {};
    for (const [ax, ay, bx, by, kind] of scene.walls) {
      const path = (this.walls[kind] ??= new Path2D());
      path.moveTo(ax, ay);
      path.lineTo(bx, by);
    }
    this.fit();
  }

  // Takes the size of the element, which may have changed.
  resize() {
    const ratio = globalThis.devicePixelRatio || 1;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight]
      .map((side) => Math.max(1, Math.round(side * ratio)));
    this.ratio = ratio;
    if (width !== this.canvas.width || height !== this.canvas.height) {
      [this.canvas.width, this.canvas.height] = [width, height];
      if (this.isFitted) this.fit();
    }
  }

  fit() {
    const [x0, y0, x1, y1] = this.scene.bounds_m;
    const margin = 0.25;
    this.centre = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.scale = Math.min(this.canvas.width / (x1 - x0 + 2 * margin),
      this.canvas.height / (y1 - y0 + 2 * margin));
    this.isFitted = true;
  }

  // Zooms about a place in CSS pixels; without one about the middle.
  zoom(factor, x = this.canvas.clientWidth / 2, y = this.canvas.clientHeight / 2) {
    const [u, v] = this.metres(x, y);
    this.scale = Math.min(5000, Math.max(2, this.scale * factor));
    const [s, t] = this.metres(x, y);
    this.centre = [this.centre[0] + u - s, this.centre[1] + v - t];
    this.isFitted = false;
  }

  // Moves what is shown by CSS pixels.
  pan(dx, dy) {
    this.centre[0] -= dx * this.ratio / this.scale;
    this.centre[1] += dy * this.ratio / this.scale;
    this.isFitted = false;
  }

  // Moves by hand: drag with one pointer, zoom with two, or with the wheel where
  // `mayWheel` says so. `moved` is told whether it was dragged.
  listen(moved, mayWheel = () => true) {
    const { canvas } = this, pointers = new Map();
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId), at = [event.offsetX, event.offsetY];
      if (!before) return;
      const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {
        const far = ([x, y]) => Math.hypot(x - other[0], y - other[1]);
        this.zoom(far(at) / Math.max(1, far(before)), ...other);
      } else this.pan(at[0] - before[0], at[1] - before[1]);
      pointers.set(event.pointerId, at);
      moved(!other);
    });
    for (const end of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    }
    canvas.addEventListener('wheel', (event) => {
      if (!mayWheel(event)) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
      moved(false);
    }, { passive: false });
  }

  metres(x, y) {
    return [this.centre[0] + (x * this.ratio - this.canvas.width / 2) / this.scale,
      this.centre[1] - (y * this.ratio - this.canvas.height / 2) / this.scale];
  }

  // The place of a point on the canvas, in its pixels.
  place(x, y) {
    return [this.canvas.width / 2 + (x - this.centre[0]) * this.scale,
      this.canvas.height / 2 - (y - this.centre[1]) * this.scale];
  }

  // `now`: { truth: [x, y, θ], truthTrack, scan: [x, y, …], estimators: [{ pose, ellipse,
  // track, belief: { kind, poses }, isShown, ink, width }] }; `inks` by name. A finished
  // run also has the whole paths, `whole` next to each track, which are faded, the
  // `start`, and `jumps`: [{ from, to, text, isPast }].
  draw(now, inks) {
    const { ctx, ratio, scale } = this;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, this.canvas.width, this.canvas.height);
    ctx.setTransform(scale, 0, 0, -scale, ...this.place(0, 0));
    ctx.lineJoin = ctx.lineCap = 'round';
    const stroke = (path, ink, pixels) => {
      ctx.strokeStyle = ink;
      ctx.lineWidth = pixels * ratio / scale;
      ctx.stroke(path);
    };
    const walls = [['wall', 2.5], ['glass', 3], ['door', 4]];
    const baseInks = [inks.grid, ...walls.map(([kind]) => inks[kind])];
    this.base.show(this, [this.walls], baseInks, (isOld, strokeBase) => {
      if (isOld) return;
      this.grid(strokeBase, inks);
      for (const [kind, pixels] of walls) {
        if (this.walls[kind]) strokeBase(this.walls[kind], inks[kind], pixels);
      }
    });
    for (const estimator of now.estimators) {
      if (estimator.isShown && estimator.belief) this.belief(estimator);
    }
    const shown = now.estimators.filter((estimator) => estimator.isShown);
    ctx.globalAlpha = FADED;
    if (now.whole) stroke(now.whole.path, inks.truth, 5);
    for (const { whole, ink, width } of shown) if (whole) stroke(whole.path, ink, width);
    ctx.globalAlpha = 1;
    this.truthPath.paths(this, [{ track: now.truthTrack, ink: inks.truth, width: 5 }]);
    this.paths.paths(this, shown);
    for (const jump of now.jumps ?? []) this.jump(jump, inks);
    if (now.start) this.start(now.start, inks);
    this.scan(now.scan, inks);
    this.robot(now.truth, inks);
    now.estimators.forEach((estimator, i) => {
      if (estimator.isShown) this.estimator(estimator, i, inks);
    });
  }

  grid(stroke, inks) {
    // Lines every metre, unless they are closer than 10 pixels.
    if (this.scale < 10) return;
    const path = new Path2D();
    const [x0, y0, x1, y1] = this.scene.bounds_m.map(Math.round);
    for (let x = x0; x <= x1; x += 1) { path.moveTo(x, y0); path.lineTo(x, y1); }
    for (let y = y0; y <= y1; y += 1) { path.moveTo(x0, y); path.lineTo(x1, y); }
    stroke(path, inks.grid, 1);
  }

  // Cells of a histogram along a corridor as bars, other poses as arrowheads; the area
  // of a cell is its share, and particles have one size.
  belief({ belief: { kind, poses }, ink }) {
    const { ctx } = this, isHistogram = kind === 2;
    let greatest = 0;
    for (let k = 3; k < poses.length; k += 4) greatest = Math.max(greatest, poses[k]);
    const bars = isHistogram ? barsOf(poses, greatest) : null;
    ctx.fillStyle = ink;
    ctx.globalAlpha = bars ? 0.6 : 0.4;
    ctx.beginPath();
    const polygon = (corners) => {
      corners.forEach(([x, y], k) => (k ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
    };
    if (bars) bars.forEach(polygon);
    const size = 4.2 * this.ratio / this.scale;
    for (let k = 0; !bars && k < poses.length; k += 4) {
      const [x, y, theta, weight] = poses.subarray(k, k + 4);
      const share = isHistogram && greatest > 0 ? weight / greatest : 1;
      const c = Math.cos(theta), s = Math.sin(theta), r = size * (0.3 + 0.7 * Math.sqrt(share));
      if (share > 0) polygon(ARROWHEAD.map(([u, v]) => [x + r * (c * u - s * v), y + r * (s * u + c * v)]));
    }
    ctx.fill();
    ctx.globalAlpha = 1;
  }

  // A kidnapping: a dotted arrow with its time.
  jump({ from, to, text, isPast }, inks) {
    const { ctx, ratio } = this;
    const [[x0, y0], [x, y]] = [this.place(...from), this.place(...to)];
    const angle = Math.atan2(y - y0, x - x0), c = Math.cos(angle), s = Math.sin(angle);
    const at = (along, aside) => [x + ratio * (along * c - aside * s), y + ratio * (along * s + aside * c)];
    ctx.save();
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.globalAlpha = isPast ? 1 : FADED;
    ctx.strokeStyle = ctx.fillStyle = inks.ink;
    ctx.lineWidth = 1.8 * ratio;
    ctx.lineCap = 'butt';
    ctx.setLineDash([2.5 * ratio, 2.5 * ratio]);
    ctx.beginPath();
    ctx.moveTo(x0, y0);
    ctx.lineTo(...at(-8, 0));
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.beginPath();
    for (const corner of [at(0, 0), at(-10, 4.5), at(-10, -4.5)]) ctx.lineTo(...corner);
    ctx.fill();
    ctx.font = `${12 * ratio}px system-ui, "DejaVu Sans", sans-serif`;
    ctx.textAlign = 'center';
    ctx.textBaseline = 'middle';
    ctx.lineWidth = 7 * ratio;
    ctx.lineJoin = 'round';
    ctx.strokeStyle = inks.card;
    ctx.strokeText(text, (x0 + x) / 2, (y0 + y) / 2);
    ctx.fillText(text, (x0 + x) / 2, (y0 + y) / 2);
    ctx.restore();
  }

  // The true pose before the first tick.
  start([x, y, theta], inks) {
    const { ctx, ratio, scale } = this, size = ratio / scale;
    ctx.strokeStyle = inks.ink;
    ctx.fillStyle = inks.card;
    ctx.lineWidth = 2.4 * size;
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(x + 13 * size * Math.cos(theta), y + 13 * size * Math.sin(theta));
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(x, y, 5.5 * size, 0, 2 * Math.PI);
    ctx.fill();
    ctx.stroke();
  }

  scan(points, inks) {
    const { ctx, ratio, scale } = this;
    for (const [pixels, ink] of [[5, inks.rim], [3, inks.scan]]) {
      const size = pixels * ratio / scale;
      ctx.beginPath();
      for (let k = 0; k < points.length; k += 2) {
        ctx.rect(points[k] - size / 2, points[k + 1] - size / 2, size, size);
      }
      ctx.fillStyle = ink;
      ctx.fill();
    }
  }

  // The true robot: its body, and where its front is.
  robot([x, y, theta], inks) {
    if (!Number.isFinite(x + y + theta)) return;
    const { ctx, ratio, scale } = this;
    const radius = Math.max(this.scene.body_radius_m, 4 * ratio / scale);
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    ctx.fillStyle = inks.card;
    ctx.fill();
    ctx.moveTo(x, y);
    ctx.lineTo(x + radius * Math.cos(theta), y + radius * Math.sin(theta));
    ctx.strokeStyle = inks.ink;
    ctx.lineWidth = 2 * ratio / scale;
    ctx.stroke();
  }

  // Where an estimator believes the robot is: a see-through body, its ellipse, its mark.
  estimator({ pose: [x, y, theta], ellipse: [xx, yx, yy], ink }, index, inks) {
    if (!Number.isFinite(x + y + theta)) return;
    const { ctx, ratio, scale } = this;
    ctx.lineWidth = 1.6 * ratio / scale;
    ctx.strokeStyle = ctx.fillStyle = ink;
    if (Number.isFinite(xx + yx + yy)) {
      ctx.beginPath();
      for (let k = 0; k < 48; k += 1) {
        const c = Math.cos(k * Math.PI / 24), s = Math.sin(k * Math.PI / 24);
        ctx.lineTo(x + xx * c, y + yx * c + yy * s);
      }
      ctx.closePath();
      ctx.globalAlpha = 0.15;
      ctx.fill();
      ctx.globalAlpha = 1;
      ctx.stroke();
    }
    const radius = Math.max(this.scene.body_radius_m, 4 * ratio / scale);
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    ctx.globalAlpha = 0.3;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.moveTo(x, y);
    ctx.lineTo(x + 1.6 * radius * Math.cos(theta), y + 1.6 * radius * Math.sin(theta));
    ctx.stroke();
    ctx.save();
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    mark(ctx, index, this.place(x, y), 4 * ratio, ink, inks.card);
    ctx.restore();
  }
}
