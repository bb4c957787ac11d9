// Charts of a run, one above the other, with the scene's time as a line through all of them.
import { clock } from "helimag-studio/clock.js";
import { place, runs, scalar } from "helimag-studio/runs.js";
import { FONT, colour, on_theme, sized, ticks, written } from "helimag-studio/ticks.js";

const LEFT = 46;
const RIGHT = 12;
const TOP = 20;
const GAP = 8;
const FOOT = 22;

const PANELS = [
  { title: "Height of the head", unit: "mm", lines: [["height", "height", "blue"]], band: ["low", "high"] },
  { title: "Gap to the magnet", unit: "mm", lines: [["gap", "gap", "blue"]] },
  { title: "Attack angle, head up", unit: "deg", lines: [["attack", "attack", "blue"]] },
  { title: "Lag behind the field", unit: "deg", lines: [["lag", "lag", "blue"]], soft: true },
  {
    title: "Vertical forces",
    unit: "µN",
    times: "forces_time",
    lines: [
      ["pull", "pull", "vermillion"],
      ["weight", "weight", "grey"],
      ["thrust", "thrust", "green"],
    ],
    legend: true,
    cut: true,
  },
];
const USUAL = 0.96; // share of the values that an axis shows at least, where the rest would flatten them: a pull at contact
const OUT = 5; // times as far as those

export default {
  template: `
    <div class="hs-charts" @pointerdown="grab" @pointermove="move" @pointerup="held = false" @pointerleave="held = false"
         role="img" aria-label="Charts of the run over time">
      <canvas ref="still"></canvas><canvas ref="moving" class="hs-over"></canvas>
    </div>`,
  mounted() {
    this.quit = [
      runs.listen(() => this.draw()),
      clock.listen(() => this.mark()),
      on_theme(() => this.draw()),
    ];
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(this.$el);
    this.draw();
  },
  unmounted() {
    this.quit.forEach((stop) => stop());
    this.observer.disconnect();
  },
  data: () => ({ held: false }),
  methods: {
    draw() {
      const width = this.$el.clientWidth;
      const height = this.$el.clientHeight;
      if (!width || !height) return;
      const run = runs.live;
      const pen = sized(this.$refs.still, width, height);
      this.size = [width, height];
      this.shown = null;
      if (!run) return;
      pen.font = FONT;
      this.end = Math.max(run.duration, ...runs.others.map((other) => other.time[other.time.length - 1]));
      const each = (height - FOOT) / PANELS.length;
      this.frames = PANELS.map((panel, i) => this.frame_of(panel, run, i * each + TOP, each - TOP - GAP));
      PANELS.forEach((panel, i) => this.panel(pen, panel, this.frames[i], run));
      this.times(pen, height);
      this.mark();
    },
    x(time) {
      return LEFT + ((this.size[0] - LEFT - RIGHT) * time) / this.end;
    },
    frame_of(panel, run, top, height) {
      let low = Infinity;
      let high = -Infinity;
      let cut = false;
      for (const each of [run, ...runs.others])
        for (const [name] of panel.lines.concat((panel.band || []).map((b) => [b])))
          if (each[name]) {
            const found = panel.cut ? usual(each[name]) : all(each[name]);
            low = Math.min(low, found.low);
            high = Math.max(high, found.high);
            cut = cut || found.cut;
          }
      if (!(low <= high)) [low, high] = [-1, 1];
      const room = Math.max(0.08 * (high - low), 0.02 * Math.max(Math.abs(low), Math.abs(high)), 1e-3);
      return { top, height, low: low - room, high: high + room, cut };
    },
    y(frame, value) {
      return frame.top + (frame.height * (frame.high - value)) / (frame.high - frame.low);
    },
    panel(pen, panel, frame, run) {
      const right = this.size[0] - RIGHT;
      const { found, digits } = ticks(frame.low, frame.high, Math.max(2, Math.floor(frame.height / 26)));
      pen.lineWidth = 1;
      pen.textAlign = "right";
      pen.textBaseline = "middle";
      for (const tick of found) {
        const y = Math.round(this.y(frame, tick)) + 0.5;
        pen.strokeStyle = colour("grid");
        pen.beginPath();
        pen.moveTo(LEFT, y);
        pen.lineTo(right, y);
        pen.stroke();
        pen.fillStyle = colour("muted");
        pen.fillText(written(tick, digits), LEFT - 6, y);
      }
      pen.textAlign = "left";
      pen.fillStyle = colour("text");
      pen.fillText(panel.title, LEFT, frame.top - 10);
      pen.fillStyle = colour("muted");
      pen.fillText(panel.unit + (frame.cut ? ", peak cut off" : ""), LEFT + pen.measureText(panel.title).width + 6, frame.top - 10);
      pen.save();
      pen.beginPath();
      pen.rect(LEFT, frame.top, right - LEFT, frame.height);
      pen.clip();
      if (panel.band) this.band(pen, panel, frame, run);
      runs.others.forEach((other, i) => this.lines(pen, panel, frame, other, i));
      this.lines(pen, panel, frame, run, -1);
      pen.restore();
      if (panel.legend) this.legend(pen, panel, frame, right);
    },
    band(pen, panel, frame, run) {
      pen.fillStyle = colour("band");
      pen.beginPath();
      run.time.forEach((time, i) => pen.lineTo(this.x(time), this.y(frame, run[panel.band[1]][i])));
      for (let i = run.time.length - 1; i >= 0; i--) pen.lineTo(this.x(run.time[i]), this.y(frame, run[panel.band[0]][i]));
      pen.fill();
    },
    lines(pen, panel, frame, run, other) {
      const times = run[panel.times || "time"];
      if (!times) return;
      for (const [name, , shade] of panel.lines) {
        if (!run[name]) continue;
        const values = run[name];
        pen.strokeStyle = other < 0 ? colour(shade) : colour("other" + (other % 3));
        pen.lineWidth = panel.soft ? 0.7 : other < 0 ? 1.6 : 1.2;
        pen.globalAlpha = panel.soft ? 0.55 : 1;
        pen.setLineDash(other < 0 ? [] : [5, 3]);
        pen.beginPath();
        let down = false;
        values.forEach((value, i) => {
          if (Number.isFinite(value)) {
            if (down) pen.lineTo(this.x(times[i]), this.y(frame, value));
            else pen.moveTo(this.x(times[i]), this.y(frame, value));
          }
          down = Number.isFinite(value);
        });
        pen.stroke();
        pen.setLineDash([]);
        pen.globalAlpha = 1;
      }
    },
    legend(pen, panel, frame, right) {
      pen.textAlign = "right";
      let x = right;
      for (const [, label, shade] of [...panel.lines].reverse()) {
        pen.fillStyle = colour(shade);
        pen.fillText(label, x, frame.top - 10);
        x -= pen.measureText(label).width + 10;
      }
    },
    times(pen, height) {
      const { found, digits } = ticks(0, this.end, Math.max(2, Math.floor(this.size[0] / 90)));
      pen.textAlign = "center";
      pen.fillStyle = colour("muted");
      for (const tick of found) {
        const label = tick.toFixed(digits) + (tick === found[found.length - 1] ? " s" : "");
        pen.fillText(label, Math.min(this.x(tick), this.size[0] - 18), height - 8);
      }
    },
    // the line of now, and the values there
    mark() {
      const run = runs.live;
      if (!run || !this.frames) return;
      const key = clock.time + "/" + this.size;
      if (key === this.shown) return;
      this.shown = key;
      const pen = sized(this.$refs.moving, ...this.size);
      const x = Math.round(this.x(clock.time)) + 0.5;
      pen.strokeStyle = colour("accent");
      pen.beginPath();
      pen.moveTo(x, TOP);
      pen.lineTo(x, this.size[1] - FOOT);
      pen.stroke();
      pen.font = FONT;
      pen.textBaseline = "middle";
      PANELS.forEach((panel, i) => {
        if (panel.legend) return;
        const at = place(run.time, clock.time);
        const name = panel.lines[0][0];
        const value = scalar(run[name], at);
        pen.textAlign = "right";
        pen.fillStyle = colour("text");
        const label = Number.isFinite(value) ? written(value, 1) : "out of step";
        pen.fillText(label, this.size[0] - RIGHT, this.frames[i].top - 10);
        pen.fillStyle = colour("accent");
        pen.beginPath();
        if (Number.isFinite(value)) pen.arc(x, this.y(this.frames[i], value), 3, 0, 7);
        pen.fill();
      });
    },
    grab(event) {
      this.held = true;
      this.move(event);
    },
    move(event) {
      if (!this.held || !this.size) return;
      const x = event.clientX - this.$el.getBoundingClientRect().left;
      clock.playing = false;
      clock.seek(((x - LEFT) / (this.size[0] - LEFT - RIGHT)) * this.end);
    },
  },
};

function all(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return { low, high, cut: false };
}

// where all but a few values lie, if those few lie far away
function usual(values) {
  const whole = all(values);
  const sorted = Float32Array.from(values).filter(Number.isFinite).sort();
  if (!sorted.length) return whole;
  const edge = Math.floor(((1 - USUAL) / 2) * sorted.length);
  const [low, high] = [sorted[edge], sorted[sorted.length - 1 - edge]];
  const reach = OUT * Math.max(high - low, Math.abs(low), Math.abs(high));
  return whole.high > high + reach || whole.low < low - reach ? { low, high, cut: true } : whole;
}
