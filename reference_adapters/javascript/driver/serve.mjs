// Serves one engine: a scene per line in, its result per line out, as JSON; see workers/process.py.
//
//     node serve.mjs FOLDER ENGINE CONFIG
//
// FOLDER contains node_modules with the engines; ENGINE.mjs is in the folder of this script; CONFIG is tuned
// or naive. If files of scenes follow, the script simulates these scenes and exits. `ghostball grade` judges
// the results, whose engine is called ENGINE-alone:
//
//     ghostball scenes --export scenes
//     node serve.mjs . planck tuned scenes/half-ball-cut.json > runs.jsonl

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";
import { Worker } from "node:worker_threads";
import { play } from "./play.mjs";

const [folder, name, config, ...files] = process.argv.slice(2);
const write = process.stdout.write.bind(process.stdout);
const answer = (value) => write(`${JSON.stringify(value)}\n`);
// Output of the engine must not mix with the answers.
process.stdout.write = process.stderr.write.bind(process.stderr);

// Exit if the parent process was killed, even if the engine is in an endless loop.
const ORPHAN = `const parent = process.ppid;
setInterval(() => process.ppid === parent || process.kill(process.pid, "SIGKILL"), 500);`;
new Worker(ORPHAN, { eval: true }).unref();

const require = createRequire(pathToFileURL(resolve(folder, "package.json")));
let driver, engine;
try {
  driver = await import(`./${name}.mjs`);
  engine = driver.load(require);
} catch (error) {
  answer({ absent: String(error).split("\n")[0] });
  process.exit(0);
}

// Settings for files of scenes; Ghostball sends its settings with each scene.
const ALONE = { config, contact_steps: "fixed", dt: config === "naive" ? 1 / 60 : 1e-3, iterations: null };
const LIMITS = { max_time: 300, max_steps: 1e7, gap: 1e-10, shortest: 0, reach: 10, sides: 240 };

// Return the largest distance that a ball moves in a step before the first impact [m]. Its largest speed is
// the initial speed, or the speed of rolling.
const reachOfStep = ({ balls }) =>
  ALONE.dt *
  Math.max(
    ...balls.map(({ radius, velocity: [x, y], angular_velocity: spin }) => {
      const [ux, uy] = spin ? [x - radius * spin[1], y + radius * spin[0]] : [0, 0];
      return Math.max(Math.hypot(x, y), Math.hypot(x - (2 / 7) * ux, y - (2 / 7) * uy));
    }),
  );

for (const file of files) {
  const scene = JSON.parse(readFileSync(file, "utf8"));
  const run = play(driver.World, engine, scene, "trajectory", { ...ALONE, ...LIMITS });
  const resolution = reachOfStep(scene) + (driver.inside?.(scene, LIMITS) ?? 0);
  answer({ engine: `${name}-alone`, resolution, ...run });
}
if (!files.length) {
  answer({ version: "1" });
  for await (const line of createInterface({ input: process.stdin })) {
    try {
      const { scene, record, settings } = JSON.parse(line);
      answer(play(driver.World, engine, scene, record, settings));
    } catch (error) {
      answer({ error: String(error?.stack ?? error).split("\n").slice(0, 2).join(" ").trim() });
    }
  }
}
