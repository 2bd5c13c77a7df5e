// The dashboard: true path against dead reckoning, two sliders, arrow keys.

// What full throttle and full lock are, m/s and rad/s.
const AHEAD_M_S = 0.5, LEFT_RAD_S = 1.5;

const page = new RunPage({
  launch: ['apartment'],
  fixed: { dt_s: 0.1, scan_every: 1, 'script.kind': 'truth-steered-patrol' },
  ticks: 300,
  rate: 20,
  stages: [
    {
      sets: { 'robot.slip_std': 0.02, 'robot.radius_bias_right': 0 },
      text: 'Slip of 2 %: the error grows and never shrinks, most of all in turns.',
    },
    {
      sets: { 'robot.slip_std': 0, 'robot.radius_bias_right': 0.01 },
      text: 'No slip, but one wheel is 1 % larger: the same error with every seed.',
    },
    {
      sets: { 'robot.slip_std': 0, 'robot.radius_bias_right': 0 },
      text: 'No slip and equal wheels: both paths coincide. The arithmetic is exact.',
    },
  ],
});

const driver = new Driver(byId('drive'), byId('pad'), byId('map'), ({ ahead, left }) => {
  page.drive(AHEAD_M_S * ahead, LEFT_RAD_S * left);
});
document.body.addEventListener('keydown', (event) => {
  if (driver.isOn && !event.target.matches('input:not([type=range])')) driver.keyDown(event);
}, true);
document.body.addEventListener('keyup', (event) => driver.keyUp(event));
byId('drive').addEventListener('click', () => {
  if (driver.isOn) say('You drive. Every command is kept: the run repeats to the bit.');
});
// Before the page begins anew.
byId('restart').addEventListener('click', () => driver.stop(), true);
byId('save').addEventListener('click', () => { page.save().catch(complain); });
globalThis.rustyWidget = page;
