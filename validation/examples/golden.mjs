// Compare answers with golden shots: node golden.mjs FOLDER ANSWERS.json
//
// ANSWERS.json holds {"NAME": {"events": [...], "rest_positions": [...]}, ...} from your engine;
// the README of the folder describes the comparison.
import { readFileSync } from "node:fs";
import { join } from "node:path";

const FACTOR = 1; // 2 ** 29 for an engine in single precision
const PHASE_ENDS = ["slide-to-roll", "roll-to-rest", "ball-cloth"];

function faults(shot, answer) {
  const numbers = [...answer.events.map((e) => e.t), ...(answer.rest_positions ?? []).flat()];
  if (!numbers.every(Number.isFinite)) return ["a number isn't finite"];
  const isBall = (one) => Number.isInteger(one) && 0 <= one && one < shot.scene.balls.length;
  const namesBalls = ({ kind, a, b }) => isBall(a) && (kind !== "ball-ball" || (isBall(b) && a !== b));
  if (!answer.events.every(namesBalls)) return [`an event must name balls by their indices, from 0 to ${shot.scene.balls.length - 1}`];
  if (shot.rest_positions && answer.rest_positions?.length !== shot.scene.balls.length) return ["number of rest positions"];
  const found = [], left = [...answer.events], tolerance = shot.tolerance;
  const kinds = new Set(["ball-ball", "ball-cushion", "pocketed", ...left.map((e) => e.kind)]);
  const key = (e) => [e.kind, ...(e.kind === "ball-ball" ? [e.a, e.b].sort((a, b) => a - b) : [e.a, e.b])].join();
  const within = (x, y, limit) => Math.abs(x - y) <= FACTOR * limit; // false for NaN
  shot.events.forEach((event, k) => {
    if (!kinds.has(event.kind)) return;
    const off = (e) => Math.abs(e.t - event.t);
    const same = left.filter((e) => key(e) === key(event)).sort((a, b) => off(a) - off(b));
    if (same.length === 0) return found.push(`missing ${event.kind} at ${event.t} s`);
    left.splice(left.indexOf(same[0]), 1);
    if (!within(same[0].t, event.t, tolerance.events[k])) found.push(`${event.kind} at ${same[0].t} instead of ${event.t} s`);
  });
  const end = shot.valid_until === null ? Infinity : shot.valid_until - FACTOR * tolerance.events.at(-1);
  for (const extra of left) {
    const near = (e, k) => (e.a === extra.a || (e.kind === "ball-ball" && e.b === extra.a)) && within(e.t, extra.t, tolerance.events[k]);
    if (extra.t < end && !(PHASE_ENDS.includes(extra.kind) && shot.events.some(near))) found.push(`extra ${extra.kind} at ${extra.t} s`);
  }
  shot.rest_positions?.forEach((place, ball) => place.forEach((x, axis) => {
    if (!within(answer.rest_positions[ball][axis], x, tolerance.rest_positions[ball])) found.push(`rest position of ball ${ball}, axis ${axis}`);
  }));
  return found;
}

const [folder, file] = process.argv.slice(2);
let failed = 0;
for (const [name, answer] of Object.entries(JSON.parse(readFileSync(file, "utf8")))) {
  const found = faults(JSON.parse(readFileSync(join(folder, `${name}.json`), "utf8")), answer);
  found.forEach((fault) => console.log(`${name}: ${fault}`));
  failed += found.length > 0;
}
process.exit(failed > 0 ? 1 : 0);
