// Moves what is drawn already to another tick. What the numbers of the data
// mean stands in the scorer's source, clients/src/report/data.rs.
'use strict';
const all = (what) => [...document.querySelectorAll(what)];
const byId = (id) => document.getElementById(id);
addEventListener('error', (event) => {
  byId('trouble').textContent = `The slider does not work here: ${event.message}`;
  byId('trouble').hidden = false;
});
const data = JSON.parse(byId('data').textContent);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const poses = new Float32Array(bytes(data.poses));
const scans = new Uint16Array(bytes(data.scans));
const [mapX, mapY, perMetre] = data.map;
const circle = 100; // radius of the drawn circle that ellipses are made of
const slider = byId('tick');
const parts = Array.from({ length: data.estimators }, (_, i) => ({
  ellipse: all(`#map .e${i}.ellipse`), nose: all(`#map .e${i}.nose`), mark: all(`#map .e${i}.mark`),
  cells: byId('readout').tBodies[0].rows[i].cells,
}));
const robot = all('#map .robot'), cursors = all('.cursor'), dots = all('#map .scan circle');
const place = (x, y) => [mapX + perMetre * x, mapY - perMetre * y];

// Gives parts a place, or hides them where there is none.
function move(elements, matrix) {
  const known = matrix.every(Number.isFinite);
  for (const element of elements) {
    element.classList.toggle('gone', !known);
    if (known) element.setAttribute('transform', `matrix(${matrix.join(' ')})`);
  }
}
const turned = (x, y, theta) => {
  const c = Math.cos(theta), s = Math.sin(theta);
  return [c, -s, s, c, ...place(x, y)];
};
const text = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '–');

// The echoes of the latest scan, from the true pose at its tick.
function showScan(stop) {
  let k = -1;
  while (k + 1 < data.scan_stops.length && data.scan_stops[k + 1] <= stop) k += 1;
  const [x, y, theta] = k < 0 ? [] : poses.slice(data.scan_stops[k] * row);
  const c = Math.cos(theta), s = Math.sin(theta), [sx, sy, turn] = data.sensor_in_body;
  for (let beam = 0; 2 * beam < dots.length; beam += 1) {
    const range = k < 0 ? 0 : scans[k * data.beams + beam] * data.range_unit_m;
    const bearing = turn + data.first_bearing_rad + beam * data.bearing_step_rad;
    const u = sx + range * Math.cos(bearing), v = sy + range * Math.sin(bearing);
    const at = range ? place(x + c * u - s * v, y + s * u + c * v) : [-1e4, -1e4];
    for (const dot of [dots[2 * beam], dots[2 * beam + 1]]) {
      dot.setAttribute('cx', at[0].toFixed(1));
      dot.setAttribute('cy', at[1].toFixed(1));
    }
  }
}

const row = 3 + 7 * data.estimators;
let shown = Number(slider.defaultValue);
function show(stop) {
  shown = stop;
  const [x, y, theta] = poses.slice(stop * row);
  move(robot, turned(x, y, theta));
  parts.forEach((part, i) => {
    const [u, v, turn, xx, yx, yy, nees] = poses.slice(stop * row + 3 + 7 * i);
    const at = place(u, v), size = perMetre / circle;
    move(part.nose, turned(u, v, turn));
    move(part.mark, [1, 0, 0, 1, ...at]);
    move(part.ellipse, [size * xx, -size * yx, 0, size * yy, ...at]);
    const off = Math.atan2(Math.sin(turn - theta), Math.cos(turn - theta)) * 180 / Math.PI;
    [text(Math.hypot(u - x, v - y), 3), text(off, 2), text(nees, 2)]
      .forEach((words, k) => { part.cells[k + 1].textContent = words; });
  });
  showScan(stop);
  const [from, to] = data.range_s, [left, right] = data.chart;
  const at = left + (data.times_s[stop] - from) / (to - from) * (right - left);
  move(cursors, [1, 0, 0, 1, at, 0]);
  const seconds = Math.round(data.times_s[stop] * 100) / 100;
  const now = `tick ${data.ticks[stop]} · ${seconds.toFixed(2)} s`;
  byId('now').textContent = now;
  slider.setAttribute('aria-valuetext', now);
}
const choose = (stop) => { slider.value = stop; show(stop); };
const nearest = (list, value) => {
  let best = 0;
  list.forEach((v, k) => { if (Math.abs(v - value) < Math.abs(list[best] - value)) best = k; });
  return best;
};
const keep = () => history.replaceState(null, '', `#tick=${data.ticks[slider.value]}`);

// A link to a tick.
function follow() {
  const asked = /^#tick=(\d+)$/.exec(location.hash);
  if (asked) choose(nearest(data.ticks, Number(asked[1])));
}
if (data.ticks.length > 0) {
  byId('control').hidden = false;
  slider.addEventListener('input', () => show(Number(slider.value)));
  slider.addEventListener('change', keep);
  addEventListener('hashchange', follow);
  slider.setAttribute('aria-valuetext', byId('now').textContent);
  follow();
  // A browser that goes back may put the slider where it was, after all this.
  addEventListener('pageshow', () => {
    if (Number(slider.value) !== shown) show(Number(slider.value));
    follow();
  });
  // A chart chooses its time, by click or by dragging, which may leave it.
  let drag = null;
  for (const chart of all('svg.chart')) {
    const point = (event) => {
      const box = chart.getBoundingClientRect(), [left, right] = data.chart;
      const at = (event.clientX - box.left) / box.width * chart.viewBox.baseVal.width;
      const [from, to] = data.range_s;
      choose(nearest(data.times_s, from + (at - left) / (right - left) * (to - from)));
    };
    chart.addEventListener('pointerdown', (event) => {
      if (event.button === 0) { drag = point; point(event); keep(); }
    });
  }
  addEventListener('pointermove', (event) => { if (drag) drag(event); });
  for (const end of ['pointerup', 'pointercancel']) {
    addEventListener(end, () => { if (drag) { drag = null; keep(); } });
  }
}
// Who is shown; a browser that goes back may set that, too.
all('.toggle').forEach((toggle, i) => {
  const apply = () => {
    all(`.e${i}`).forEach((part) => { part.style.display = toggle.checked ? '' : 'none'; });
  };
  toggle.disabled = false;
  toggle.addEventListener('change', apply);
  addEventListener('pageshow', apply);
});
