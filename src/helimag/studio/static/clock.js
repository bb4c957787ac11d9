// The time that scene and charts share: played, scrubbed, and told to all of them once a frame.
const listeners = new Set();

export const clock = {
  time: 1, // at the end: a whole run is looked at first
  end: 1,
  speed: 60,
  playing: false,
  wall: 0, // s since the page was opened, for what turns too fast to be shown as it is

  listen(listener) {
    listeners.add(listener);
    return () => listeners.delete(listener);
  },
  seek(time) {
    this.time = Math.min(this.end, Math.max(0, time));
  },
  toggle() {
    if (!this.playing && this.time >= this.end) this.seek(0);
    this.playing = !this.playing;
  },
  // a new run: what was looked at stays in view; at the end one stays at the end
  reach(end) {
    const share = this.end > 0 ? this.time / this.end : 1;
    this.end = end;
    this.time = share >= 0.999 ? end : Math.min(this.time, end);
  },
};

// keys, but for what has keys of its own
const STEPS = { ArrowLeft: -0.01, ArrowRight: 0.01, PageUp: -0.1, PageDown: 0.1 }; // of the run
window.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.closest?.("input, select, textarea, button, [role=listbox], [role=tab], [role=menu]")) return;
  if (event.key === " ") clock.toggle();
  else if (event.key in STEPS) clock.seek(clock.time + STEPS[event.key] * clock.end);
  else if (event.key === "Home") clock.seek(0);
  else if (event.key === "End") clock.seek(clock.end);
  else return;
  event.preventDefault();
});

let last = performance.now();
function frame(now) {
  const step = Math.min(0.1, (now - last) / 1000);
  last = now;
  clock.wall += step;
  if (clock.playing) {
    clock.time += step * clock.speed;
    if (clock.time > clock.end) clock.time = 0;
  }
  for (const listener of listeners) listener(clock);
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);
