// Runs as the server packs them; the live one, and those laid over it. A newer request gives up the one before.
import { clock } from "helimag-studio/clock.js";

const listeners = new Set();
let under_way = null;

export const runs = {
  live: null,
  others: [],
  listen(listener) {
    listeners.add(listener);
    return () => listeners.delete(listener);
  },
  async show(url, number) {
    if (under_way) under_way.abort();
    under_way = new AbortController();
    try {
      const run = unpack(await fetched(url, under_way.signal));
      this.live = run;
      clock.reach(run.time[run.time.length - 1]);
      tell();
      document.body.dataset.picture = number;
    } catch (error) {
      if (error.name !== "AbortError") console.warn("no picture: " + error.message);
    }
  },
  async lay_over(urls) {
    const found = await Promise.all(urls.map((url) => fetched(url).then(unpack)));
    this.others = found;
    tell();
  },
};

function tell() {
  for (const listener of listeners) listener(runs);
}

async function fetched(url, signal) {
  const answer = await fetch(window.path_prefix + url, { signal, cache: "no-store" });
  if (!answer.ok) throw new Error("status " + answer.status);
  return answer.arrayBuffer();
}

export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const run = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  for (const [name, shape] of Object.entries(run.columns)) {
    const count = shape.reduce((a, b) => a * b, 1);
    run[name] = new Float32Array(buffer, at, count);
    at += 4 * count;
  }
  run.height = Float32Array.from({ length: run.position.length / 3 }, (_, i) => run.position[3 * i + 2]);
  return run;
}

// where a time lies among samples: index below, and share of the way to the next
export function place(times, time) {
  let low = 0;
  let high = times.length - 1;
  if (high < 1 || time <= times[0]) return [0, 0];
  if (time >= times[high]) return [high - 1, 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return [low, (time - times[low]) / (times[high] - times[low])];
}

export function scalar(values, [index, share]) {
  const next = index + 1 < values.length ? values[index + 1] : values[index];
  return values[index] + share * (next - values[index]);
}

export function vector(values, [index, share]) {
  const here = 3 * index;
  const next = here + 5 < values.length ? here + 3 : here;
  return [0, 1, 2].map((i) => values[here + i] + share * (values[next + i] - values[here + i]));
}
