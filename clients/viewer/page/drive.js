// Driving: keys and buttons that are held become commands, which are renewed while they
// are held. The driver of the run stops the robot when they end.

const KEYS = {
  ArrowUp: 'ahead', KeyW: 'ahead', ArrowDown: 'back', KeyS: 'back',
  ArrowLeft: 'left', KeyA: 'left', ArrowRight: 'right', KeyD: 'right',
};
const RENEWED_MS = 50;

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
    this.timer = setInterval(() => { if (this.held.size > 0) this.send(); }, RENEWED_MS);
    this.show();
    this.home.focus({ preventScroll: true });
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
