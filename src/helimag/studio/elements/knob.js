// An input: its name, a number with its unit, a slider. The hand leads: what the server says meanwhile does not move it.
const PAUSE = 40; // ms between words to the server; the last value is always said
const OWN = 900; // ms after a move in which the slider is the hand's

export default {
  template: `
    <div class="hs-knob">
      <label class="hs-knob-label" :for="name">{{ label }}</label>
      <span class="hs-field"><input :id="name" class="hs-number" type="text" inputmode="decimal" autocomplete="off"
        :data-testid="'number-' + name" v-model="text" @keydown.enter="type" @blur="type" @focus="$event.target.select()"
        @input="writing = true"><span class="hs-unit">{{ unit }}</span></span>
      <input class="hs-range" type="range" :min="low" :max="high" :step="step" :value="place" :aria-label="label + ', ' + unit" :style="{ '--at': share }"
        :data-testid="'slider-' + name" @input="turn">
    </div>`,
  props: { name: String, label: String, unit: String, low: Number, high: Number, step: Number, value: Number },
  emits: ["turn", "typed"],
  data() {
    return { text: shown(this.value), place: this.value, writing: false };
  },
  computed: {
    share() {
      return (100 * Math.min(1, Math.max(0, (this.place - this.low) / (this.high - this.low)))).toFixed(2) + "%";
    },
  },
  watch: {
    value(value) {
      if (performance.now() - (this.moved || -OWN) < OWN && this.waiting !== undefined) return;
      this.take(value);
    },
  },
  methods: {
    take(value) {
      this.place = value;
      if (!this.writing) this.text = shown(value);
    },
    turn(event) {
      const value = +event.target.value;
      this.moved = performance.now();
      this.writing = false;
      this.take(value);
      this.waiting = value;
      if (!this.timer) this.say();
    },
    // now, and again after a pause if there was another move meanwhile
    say() {
      const said = this.waiting;
      this.$emit("turn", said);
      this.timer = setTimeout(() => {
        this.timer = null;
        if (this.waiting !== said) this.say();
        else this.rest();
      }, PAUSE);
    },
    // when the hand is still, the server's word counts again
    rest() {
      clearTimeout(this.still);
      this.still = setTimeout(() => {
        if (this.timer) return;
        this.waiting = undefined;
        this.take(this.value);
      }, OWN);
    },
    type() {
      if (!this.writing) return;
      this.writing = false;
      const value = Number(this.text.trim().replace("\u2212", "-").replace(",", "."));
      if (this.text.trim() === "" || !Number.isFinite(value)) this.take(this.value);
      else this.$emit("typed", value);
    },
    // the server refused what was typed
    reset() {
      this.writing = false;
      this.take(this.value);
    },
  },
};

function shown(value) {
  return value === null || value === undefined ? "" : String(+value.toPrecision(10)).replace("-", "\u2212");
}
