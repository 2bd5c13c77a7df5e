// Readings of the sonars and the bumper on the map, at the robot. Metres and radians.

const CONTACT_PIXELS = 5;

// Sonars: a cone to each echo. Bumper: the sectors of the body that touch something.
// `scene` has the sensors, `readings`: { sonars, sectors }, the ranges and the sectors as
// bits, each null without a reading.
export function drawSensors({ ctx, ratio, scale }, [x, y, theta], scene, readings, inks) {
  if (!Number.isFinite(x + y + theta)) return;
  ctx.save();
  ctx.translate(x, y);
  ctx.rotate(theta);
  ctx.fillStyle = inks.scan;
  // On light ground the ink needs its rim, as the scan does.
  const outlined = (pixels) => {
    for (const [extra, ink] of [[1.6, inks.rim], [0, inks.scan]]) {
      ctx.lineWidth = (pixels + extra) * ratio / scale;
      ctx.strokeStyle = ink;
      ctx.stroke();
    }
  };
  const { sonar, bumper } = scene;
  sonar?.mounts.forEach(([u, v, axis], k) => {
    const range = readings.sonars?.[k], half = sonar.aperture_rad / 2;
    if (!(range < sonar.range_max_m * (1 - 1e-6))) return;
    ctx.beginPath();
    ctx.moveTo(u, v);
    ctx.arc(u, v, range, axis - half, axis + half);
    ctx.globalAlpha = 0.1;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.beginPath();
    ctx.arc(u, v, range, axis - half, axis + half);
    outlined(1.5);
  });
  ctx.lineCap = 'butt';
  const radius = Math.max(scene.body_radius_m, 4 * ratio / scale);
  for (let k = 0; bumper && k < bumper.sectors; k += 1) {
    if (!(readings.sectors & (1 << k))) continue;
    const each = bumper.fov_rad / bumper.sectors, from = bumper.first_bearing_rad + k * each;
    ctx.beginPath();
    ctx.arc(0, 0, radius, from, from + each);
    outlined(CONTACT_PIXELS);
  }
  ctx.restore();
}
