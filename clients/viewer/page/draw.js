// The map: walls, paths, robot, scan, ellipses and beliefs on a canvas. It knows no
// socket and no page: a report could draw with it. Metres and radians, world frame.

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

// A path that grows. Points that are close to the last one are left out.
export class Track {
  constructor() { this.path = new Path2D(); this.last = null; }

  add(x, y) {
    if (!Number.isFinite(x + y)) { this.last = null; return; }
    const moved = this.last ? Math.hypot(x - this.last[0], y - this.last[1]) : Infinity;
    if (moved < 0.02) return;
    // A jump is not a way.
    if (moved > 1) this.path.moveTo(x, y);
    else this.path.lineTo(x, y);
    this.last = [x, y];
  }
}

export class MapView {
  constructor(canvas) {
    this.canvas = canvas;
    this.ctx = canvas.getContext('2d');
    this.centre = [0, 0];
    this.scale = 50;
    this.ratio = 1;
    this.isFitted = true;
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
  // track, belief: { kind, poses }, isShown, ink, width }] }; `inks` by name.
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
    this.grid(stroke, inks);
    for (const estimator of now.estimators) {
      if (estimator.isShown && estimator.belief) this.belief(estimator);
    }
    for (const [kind, pixels] of [['wall', 2.5], ['glass', 3], ['door', 4]]) {
      if (this.walls[kind]) stroke(this.walls[kind], inks[kind], pixels);
    }
    stroke(now.truthTrack.path, inks.truth, 5);
    for (const { isShown, track, ink, width } of now.estimators) {
      if (isShown) stroke(track.path, ink, width);
    }
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

  // Particles as dots, cells of a histogram as bars whose height is their share.
  belief({ belief: { kind, poses }, ink }) {
    const { ctx } = this;
    let greatest = 0;
    for (let k = 3; k < poses.length; k += 4) greatest = Math.max(greatest, poses[k]);
    ctx.fillStyle = ink;
    if (kind === 2) {
      const width = poses.length > 7 ? Math.max(0.02, Math.abs(poses[4] - poses[0]) * 0.8) : 0.1;
      ctx.globalAlpha = 0.55;
      for (let k = 0; k < poses.length; k += 4) {
        const height = greatest > 0 ? poses[k + 3] / greatest : 0;
        ctx.fillRect(poses[k] - width / 2, poses[k + 1], width, height);
      }
    } else {
      const size = 2.2 * this.ratio / this.scale;
      ctx.globalAlpha = 0.35;
      ctx.beginPath();
      for (let k = 0; k < poses.length; k += 4) {
        ctx.rect(poses[k] - size / 2, poses[k + 1] - size / 2, size, size);
      }
      ctx.fill();
    }
    ctx.globalAlpha = 1;
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
