// Axes of charts and maps, and numbers as the page writes them.
export function ticks(low, high, wanted) {
  const raw = (0.8 * (high - low)) / Math.max(1, wanted);
  const power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

export function sized(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== across || canvas.height !== down) {
    canvas.width = across;
    canvas.height = down;
    canvas.style.width = width + "px";
    canvas.style.height = height + "px";
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return pen;
}

// the page's colours, asked for once: the browser would work out all its styles anew at each asking
const colours = new Map();
const listeners = new Set();

export function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.body).getPropertyValue("--hs-" + name).trim());
  return colours.get(name);
}

// calls back whenever the page changes between dark and light
export function on_theme(callback) {
  listeners.add(callback);
  return () => listeners.delete(callback);
}

new MutationObserver(() => {
  colours.clear();
  for (const listener of listeners) listener();
}).observe(document.body, { attributes: true, attributeFilter: ["class"] });

// a number with a real minus, and no minus before nought
export function written(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "\u2212");
}

export const FONT = "11px Roboto, 'Helvetica Neue', sans-serif";
