// Moves what filters held possible along; only pages that have any have this.
// What the numbers mean stands in clients/src/report/beliefs.rs.
const tracks = data.beliefs.map((track, k) => ({
  ...track, heads: all(`#map .b${k} polygon`), bytes: new DataView(bytes(track.poses)),
}));
function showBeliefs(stop) {
  const words = tracks.map((track) => {
    let k = -1;
    while (k + 1 < track.ticks.length && track.ticks[k + 1] <= data.ticks[stop]) k += 1;
    track.heads.forEach((head, place) => {
      const at = 6 * (k * track.marks + place);
      const share = k < 0 ? 0 : track.bytes.getUint8(at + 5) / 255;
      head.classList.toggle('gone', share === 0);
      if (share === 0) return;
      const x = track.bytes.getUint16(at, true), y = track.bytes.getUint16(at + 2, true);
      const turn = track.bytes.getUint8(at + 4) / 128 * Math.PI;
      const c = Math.cos(turn), s = Math.sin(turn), size = data.head * (0.3 + 0.7 * Math.sqrt(share));
      head.setAttribute('points', data.corners
        .map(([u, v]) => `${Math.round(x + size * (c * u - s * v))},${Math.round(y - size * (s * u + c * v))}`)
        .join(' '));
    });
    return k < 0 ? `${track.name}: –`
      : `${track.name}: ${track.kinds[k]} ${track.whole[k]}, tick ${track.ticks[k]}`;
  });
  byId('beliefs').textContent = words.join(' · ');
}
// Whoever shows a stop shows these with it.
const showRest = show;
show = (stop) => { showRest(stop); showBeliefs(stop); };
if (data.ticks.length > 0) show(shown);
