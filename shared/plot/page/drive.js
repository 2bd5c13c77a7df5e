// Driving: keys and buttons that are held, or the stick of a game pad, become commands,
// which are renewed while they last. The driver of the run stops the robot when they end.

const KEYS = {
  ArrowUp: 'ahead', KeyW: 'ahead', ArrowDown: 'back', KeyS: 'back',
  ArrowLeft: 'left', KeyA: 'left', ArrowRight: 'right', KeyD: 'right',
};
const RENEWED_MS = 50;
const STANDING = { ahead: 0, left: 0 };
// A stick that nobody touches is not quite in its middle.
const DEAD_ZONE = 0.15;

// What the first game pad says with its left stick or its cross (standard mapping).
function padCommand() {
  const pad = [...(navigator.getGamepads?.() ?? [])].find((one) => one?.connected);
  // A page that is not seen does not drive.
  if (!pad || document.hidden || !document.hasFocus()) return STANDING;
  const stick = (k) => (Math.abs(pad.axes[k]) > DEAD_ZONE ? Math.max(-1, Math.min(1, -pad.axes[k])) : 0);
  const cross = (one, other) => Number(pad.buttons[one]?.pressed ?? false) - Number(pad.buttons[other]?.pressed ?? false);
  return { ahead: cross(12, 13) || stick(1), left: cross(14, 15) || stick(0) };
}

export class Driver {
  // `toggle` begins and ends driving, `pad` has the buttons, `home` gets the focus.
  constructor(toggle, pad, home, ask) {
    Object.assign(this, { toggle, pad, home, ask, held: new Set(), timer: null });
    toggle.addEventListener('click', () => (this.isOn ? this.stop() : this.start()));
    for (const button of pad.querySelectorAll('button')) this.listen(button);
    // A page that is not seen does not drive.
    addEventListener('blur', () => this.release());
    document.addEventListener('visibilitychange', () => this.release());
  }

  get isOn() { return this.timer !== null; }

  start() {
    this.timer = setInterval(() => this.renew(), RENEWED_MS);
    this.show();
    this.home.focus({ preventScroll: true });
  }

  renew() {
    const pad = padCommand(), isMoved = pad.ahead !== 0 || pad.left !== 0;
    if (this.held.size > 0) this.send();
    else if (isMoved || this.isPadMoved) this.ask({ do: 'drive', ...pad });
    this.isPadMoved = isMoved;
  }

  stop() {
    if (!this.isOn) return;
    clearInterval(this.timer);
    this.timer = null;
    this.held.clear();
    this.send();
    this.show();
  }

  show() {
    this.toggle.setAttribute('aria-pressed', this.isOn);
    this.pad.hidden = !this.isOn;
  }

  listen(button) {
    const { key } = button.dataset;
    button.addEventListener('pointerdown', (event) => {
      button.setPointerCapture(event.pointerId);
      this.hold(key, true);
    });
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      button.addEventListener(end, () => { if (this.held.has(key)) this.hold(key, false); });
    }
  }

  hold(key, isDown) {
    if (isDown) this.held.add(key);
    else this.held.delete(key);
    this.send();
  }

  release() {
    if (this.held.size === 0) return;
    this.held.clear();
    this.send();
  }

  send() {
    const part = (one, other) => Number(this.held.has(one)) - Number(this.held.has(other));
    this.ask({ do: 'drive', ahead: part('ahead', 'back'), left: part('left', 'right') });
  }

  keyDown(event) {
    const key = KEYS[event.code];
    if (key) { if (!event.repeat) this.hold(key, true); }
    else if (event.code === 'Space') { this.held.clear(); this.send(); }
    else if (event.code === 'Escape') this.stop();
    else return;
    event.preventDefault();
  }

  keyUp(event) {
    const key = KEYS[event.code];
    if (!this.isOn || !this.held.has(key)) return;
    event.preventDefault();
    this.hold(key, false);
  }
}
