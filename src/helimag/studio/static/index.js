export { clock } from "helimag-studio/clock.js";
export { runs } from "helimag-studio/runs.js";
