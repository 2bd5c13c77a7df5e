// A value of each estimator over time on a canvas, with axes that follow what is shown.

const LEFT = 46, RIGHT = 8, TOP = 6, BOTTOM = 18;

// At most `most` round numbers from `low` to `high`.
function steps(low, high, most) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((size) => size >= rough);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k += 1) {
    found.push(Number((k * step).toPrecision(12)));
  }
  return found;
}

const label = (value) => (Math.abs(value) >= 1e4 || (value !== 0 && Math.abs(value) < 1e-3)
  ? value.toExponential(0) : String(Number(value.toPrecision(3))));

export class Chart {
  // `value(row, estimator)`; `line`: a value to compare with.
  constructor(canvas, value, line) {
    Object.assign(this, { canvas, value, line, ctx: canvas.getContext('2d'), times: [0, 1] });
  }

  // The time at a place in CSS pixels from the left.
  timeAt(x) {
    const share = (x - LEFT) / Math.max(1, this.canvas.clientWidth - LEFT - RIGHT);
    return this.times[0] + Math.min(1, Math.max(0, share)) * (this.times[1] - this.times[0]);
  }

  // `rows` over time; `estimators`: [{ isShown, ink }]; `cursor`: a time.
  draw(rows, time, estimators, { isLog, cursor, inks, to }) {
    const { canvas, ctx } = this, ratio = globalThis.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    const [columns, lines] = [Math.round(width * ratio), Math.round(height * ratio)];
    // Another size also clears it.
    if (columns !== canvas.width || lines !== canvas.height) [canvas.width, canvas.height] = [columns, lines];
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const from = rows.length ? time(rows[0]) : 0;
    this.times = [from, Math.max(to, from + 1e-9)];
    const shown = estimators.map((of, i) => ({ ...of, i })).filter((of) => of.isShown);
    const [low, high] = this.range(rows, shown, isLog);
    const x = (t) => LEFT + (t - from) / (this.times[1] - from) * (width - LEFT - RIGHT);
    const up = isLog ? (v) => Math.log10(v / low) / Math.log10(high / low)
      : (v) => (v - low) / (high - low);
    const y = (v) => height - BOTTOM - up(v) * (height - TOP - BOTTOM);
    this.axes({ x, y, low, high, isLog, inks, width, height });
    ctx.save();
    ctx.beginPath();
    ctx.rect(LEFT, 0, width - LEFT - RIGHT + 1, height - BOTTOM);
    ctx.clip();
    ctx.lineJoin = 'round';
    for (const { i, ink } of shown) {
      ctx.beginPath();
      this.trace(rows, (row) => this.value(row, i), { x: (row) => x(time(row)), y, isLog });
      ctx.strokeStyle = ink;
      ctx.lineWidth = 1.6;
      ctx.stroke();
    }
    if (Number.isFinite(cursor)) {
      ctx.beginPath();
      ctx.moveTo(x(cursor), 0);
      ctx.lineTo(x(cursor), height);
      ctx.strokeStyle = inks.ink;
      ctx.lineWidth = 1;
      ctx.stroke();
    }
    ctx.restore();
  }

  // Of all rows in a column of pixels the least and the greatest value.
  trace(rows, value, { x, y, isLog }) {
    const { ctx } = this;
    let column = NaN, least = Infinity, greatest = -Infinity, isDown = false;
    const flush = () => {
      if (least > greatest) return;
      if (isDown) ctx.lineTo(column, y(least));
      else ctx.moveTo(column, y(least));
      if (greatest > least) ctx.lineTo(column, y(greatest));
      else if (!isDown) ctx.lineTo(column, y(least));
      [least, greatest, isDown] = [Infinity, -Infinity, true];
    };
    for (const row of rows) {
      const v = value(row), at = Math.round(x(row) * 2) / 2;
      if (at !== column) { flush(); column = at; }
      if (!Number.isFinite(v) || (isLog && v <= 0)) {
        flush();
        isDown = false;
      } else { least = Math.min(least, v); greatest = Math.max(greatest, v); }
    }
    flush();
  }

  range(rows, shown, isLog) {
    let low = Infinity, high = -Infinity;
    for (const row of rows) {
      for (const { i } of shown) {
        const v = this.value(row, i);
        if (v > high) high = v;
        if (v < low && (!isLog || v > 0)) low = v;
      }
    }
    if (this.line && high > 0) [low, high] = [Math.min(low, this.line), Math.max(high, this.line)];
    if (isLog) {
      [low, high] = high > 0 && low < Infinity ? [low, high] : [0.1, 1];
      // Over more decades nothing is seen.
      return [Math.max(low, high * 1e-6) / 1.3, high * 1.3];
    }
    return [0, high > 0 ? high * 1.05 : 1];
  }

  axes({ x, y, low, high, isLog, inks, width, height }) {
    const { ctx } = this;
    ctx.font = '11px system-ui, "DejaVu Sans", sans-serif';
    ctx.lineWidth = 1;
    const marks = isLog
      ? steps(Math.log10(low), Math.log10(high), 4).filter(Number.isInteger).map((k) => 10 ** k)
      : steps(low, high, 4);
    ctx.textAlign = 'right';
    ctx.textBaseline = 'middle';
    for (const value of marks) {
      ctx.strokeStyle = inks.grid;
      ctx.beginPath();
      ctx.moveTo(LEFT, y(value));
      ctx.lineTo(width - RIGHT, y(value));
      ctx.stroke();
      ctx.fillStyle = inks.soft;
      ctx.fillText(label(value), LEFT - 5, y(value));
    }
    ctx.textAlign = 'center';
    ctx.textBaseline = 'alphabetic';
    for (const t of steps(...this.times, Math.max(2, width / 90))) {
      ctx.fillText(`${label(t)} s`, Math.min(width - 14, Math.max(LEFT, x(t))), height - 4);
    }
    if (this.line) {
      ctx.setLineDash([4, 4]);
      ctx.strokeStyle = inks.soft;
      ctx.beginPath();
      ctx.moveTo(LEFT, y(this.line));
      ctx.lineTo(width - RIGHT, y(this.line));
      ctx.stroke();
      ctx.setLineDash([]);
    }
  }
}
