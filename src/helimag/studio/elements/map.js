// A map over two inputs, filled in as its runs come in; a click takes the sliders there.
import { FONT, colour, on_theme, sized, ticks, written } from "helimag-studio/ticks.js";

const LEFT = 52;
const RIGHT = 14;
const TOP = 12;
const FOOT = 40;
// viridis, even in lightness, at nine places
const SHADES = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

export default {
  template: `
    <div class="hs-map" data-testid="map" @click="pick" @pointermove="hover" @pointerleave="told = null" role="img"
         :aria-label="'Map over ' + first.label + ' and ' + second.label" :data-cells="cells.length" :data-curves="curves.length"
         :data-box="box ? box.join(' ') : ''">
      <canvas ref="canvas"></canvas>
      <div v-if="told" class="hs-tip" :style="{left: told.x + 'px', top: told.y + 'px'}">{{ told.text }}</div>
    </div>`,
  props: {
    first: Object, // label, unit, low, high
    second: Object,
    cells: Array, // [x, y, width, height, gain or growth, verdict's number, words]
    curves: Array, // {kind, points: [[x, y], ...]}
    point: Array,
    box: Array, // half widths of the tolerances, about the point that they are of: [x, y, dx, dy]
    what: String, // gain or stability
    stale: Boolean,
  },
  emits: ["pick"],
  data: () => ({ told: null }),
  mounted() {
    this.quit = on_theme(() => this.draw());
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(this.$el);
  },
  unmounted() {
    this.quit();
    this.observer.disconnect();
  },
  updated() {
    this.draw();
  },
  methods: {
    x(value) {
      return LEFT + ((this.size[0] - LEFT - RIGHT) * (value - this.first.low)) / (this.first.high - this.first.low);
    },
    y(value) {
      const share = (value - this.second.low) / (this.second.high - this.second.low);
      return TOP + (this.size[1] - TOP - FOOT) * (1 - share);
    },
    shade(cell) {
      const [, , , , number, , , inside] = cell;
      if (this.what === "stability") return colour(number === null ? "void" : number < 0 ? "stable" : "unstable");
      if (!inside) return null;
      return SHADES[Math.round(8 * Math.min(1, Math.max(0, number)))];
    },
    draw() {
      const width = this.$el.clientWidth;
      const height = this.$el.clientHeight;
      if (!width || !height) return;
      this.size = [width, height];
      const pen = sized(this.$refs.canvas, width, height);
      pen.font = FONT;
      pen.fillStyle = colour("void");
      pen.fillRect(LEFT, TOP, width - LEFT - RIGHT, height - TOP - FOOT);
      pen.save();
      pen.beginPath();
      pen.rect(LEFT, TOP, width - LEFT - RIGHT, height - TOP - FOOT);
      pen.clip();
      pen.globalAlpha = this.stale ? 0.35 : 1;
      for (const cell of this.cells) this.cell(pen, cell);
      pen.globalAlpha = 1;
      for (const curve of this.curves) this.curve(pen, curve);
      if (this.box) this.tolerance(pen);
      pen.restore();
      this.cross(pen);
      this.axes(pen);
    },
    cell(pen, cell) {
      const [x, y, w, h, , verdict] = cell;
      const [left, right, top, bottom] = [this.x(x - w / 2), this.x(x + w / 2), this.y(y + h / 2), this.y(y - h / 2)];
      const shade = this.shade(cell);
      const area = [left, top, right - left + 0.6, bottom - top + 0.6];
      pen.fillStyle = shade || colour("lost");
      pen.fillRect(...area);
      if (!shade) this.lost(pen, area, verdict);
    },
    // lost runs differ by their marks, not by colour alone
    lost(pen, [left, top, width, height], verdict) {
      const mark = { attracted: "\u25b2", fell: "\u25bc", "wall-limited": "\u25a0" }[verdict];
      pen.fillStyle = colour("muted");
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      if (mark && width > 9 && height > 9) pen.fillText(mark, left + width / 2, top + height / 2);
    },
    curve(pen, curve) {
      for (const [shade, wide] of [["panel", 4], ["text", 1.8]]) {
        pen.strokeStyle = colour(shade);
        pen.lineWidth = wide;
        pen.setLineDash(curve.kind === "fold" ? [] : [6, 3]);
        pen.beginPath();
        curve.points.forEach(([x, y]) => pen.lineTo(this.x(x), this.y(y)));
        pen.stroke();
      }
      pen.setLineDash([]);
    },
    tolerance(pen) {
      const [x, y, dx, dy] = this.box;
      pen.strokeStyle = colour("vermillion");
      pen.lineWidth = 2;
      pen.strokeRect(this.x(x - dx), this.y(y + dy), this.x(x + dx) - this.x(x - dx), this.y(y - dy) - this.y(y + dy));
    },
    cross(pen) {
      const [x, y] = [this.x(this.point[0]), this.y(this.point[1])];
      for (const [shade, wide] of [["panel", 5], ["vermillion", 2]]) {
        pen.strokeStyle = colour(shade);
        pen.lineWidth = wide;
        pen.beginPath();
        pen.arc(x, y, 6, 0, 7);
        pen.moveTo(x - 11, y);
        pen.lineTo(x + 11, y);
        pen.moveTo(x, y - 11);
        pen.lineTo(x, y + 11);
        pen.stroke();
      }
    },
    axes(pen) {
      const [width, height] = this.size;
      pen.fillStyle = colour("muted");
      pen.textBaseline = "middle";
      const across = ticks(this.first.low, this.first.high, Math.max(2, Math.floor(width / 80)));
      pen.textAlign = "center";
      for (const tick of across.found)
        pen.fillText(written(tick, across.digits), this.x(tick), height - FOOT + 12);
      const up = ticks(this.second.low, this.second.high, Math.max(2, Math.floor(height / 50)));
      pen.textAlign = "right";
      for (const tick of up.found) pen.fillText(written(tick, up.digits), LEFT - 6, this.y(tick));
      pen.fillStyle = colour("text");
      pen.textAlign = "center";
      pen.fillText(`${this.first.label} (${this.first.unit})`, (LEFT + width - RIGHT) / 2, height - 10);
      pen.save();
      pen.translate(10, (TOP + height - FOOT) / 2);
      pen.rotate(-Math.PI / 2);
      pen.fillText(`${this.second.label} (${this.second.unit})`, 0, 0);
      pen.restore();
    },
    at(event) {
      const box = this.$el.getBoundingClientRect();
      const [x, y] = [event.clientX - box.left, event.clientY - box.top];
      const across = (x - LEFT) / (this.size[0] - LEFT - RIGHT);
      const up = 1 - (y - TOP) / (this.size[1] - TOP - FOOT);
      if (across < 0 || across > 1 || up < 0 || up > 1) return null;
      const value = (axis, share) => axis.low + share * (axis.high - axis.low);
      return { x, y, values: [value(this.first, across), value(this.second, up)] };
    },
    pick(event) {
      const found = this.at(event);
      if (found) this.$emit("pick", found.values);
    },
    hover(event) {
      const found = this.at(event);
      if (!found) return (this.told = null);
      const [a, b] = found.values;
      // the last that covers the place: finer cells come later
      const cell = this.cells.findLast(
        ([x, y, w, h]) => Math.abs(x - a) <= w / 2 + 1e-12 && Math.abs(y - b) <= h / 2 + 1e-12,
      );
      this.told = cell ? { x: Math.min(found.x + 14, this.size[0] - 150), y: found.y + 14, text: cell[6] } : null;
    },
  },
};
