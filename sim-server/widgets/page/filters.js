// EKF and MCL in the Apartment, with a robot that is kidnapped.

// Places with a metre of room to either side, in turn.
const PLACES = [
  { x_m: 4.4, y_m: 2.2, theta_rad: 1.9 }, { x_m: 9.6, y_m: 3, theta_rad: 2.5 },
  { x_m: 1.6, y_m: 6.6, theta_rad: -1.2 },
];

// As `--add ekf=ekf` does: behind the last estimator.
BASE.participant.splice(2, 0, { name: 'ekf', role: 'estimator', command: ['ekf'] });

const sets = { 'robot.slip_std': 0.02, 'lidar.dropout': 0.02 };
const page = new RunPage({
  launch: ['clients/filters/scenarios/kidnapped.toml', '--add', 'ekf=ekf'],
  fixed: {},
  ticks: BASE.ticks,
  rate: 100,
  stages: [{
    sets,
    text: 'After 10 s the robot is carried to another room, and no filter is told. MCL finds it again; the EKF, which follows one pose, sees that it is lost, gives no answer and searches.',
  }, {
    sets: { ...sets, 'lidar.dropout': 0.5 },
    text: 'Half of the beams are lost. MCL still finds the robot.',
  }],
});

let next = 0;
byId('kidnap').addEventListener('click', () => {
  page.kidnap(PLACES[next++ % PLACES.length]);
  say('The robot is carried away. Watch which filter finds out.');
});
document.body.addEventListener('keydown', ({ key, target }) => {
  if (key.toLowerCase() === 'k' && !target.matches('input')) byId('kidnap').click();
});
globalThis.rustyWidget = page;
