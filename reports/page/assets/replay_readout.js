"use strict";
// The table of engines: which are shown, position of the selected ball, distance from the reference.
globalThis.Ghostball ??= {};

(() => {
  const { PHASE, css, drawMarker, make, timeWords } = Ghostball;
  const PHASE_WORDS = {
    [PHASE.RESTING]: "rests",
    [PHASE.SLIDING]: "slides",
    [PHASE.ROLLING]: "rolls",
    [PHASE.GONE]: "is gone",
    [PHASE.FLYING]: "flies",
    [PHASE.UNKNOWN]: "–",
    [PHASE.ABSENT]: "lost",
  };
  const FLAT = ["distance [mm]", "x [mm]", "y [mm]", "motion"];
  const HIGH = ["distance [mm]", "x [mm]", "y [mm]", "z [mm]", "motion"]; // if a ball leaves the cloth
  const WORDS = ["rest error", "first wrong collision"];

  const millimetres = (metres) => (1e3 * metres).toFixed(2);

  /** Formats a distance with a suitable unit and three digits. */
  function distanceWords(metres) {
    if (metres === 0) return "0";
    if (metres < 1e-12) return `${metres.toExponential(1)} m`;
    const [unit, size] = [["m", 1], ["mm", 1e-3], ["µm", 1e-6], ["nm", 1e-9], ["pm", 1e-12]].find(
      ([, one]) => metres >= 0.9995 * one,
    );
    return `${Number((metres / size).toPrecision(3))} ${unit}`;
  }

  /** Formats a rest error in the form of all tables. */
  function standingWords({ standing, exact }, metres) {
    const words = exact ? "rounding" : distanceWords(metres);
    switch (standing) {
      case "judged": return words;
      case "unjudged": return `(${words})`;
      case "chaotic": return "(unpredictable)";
      default: return "–";
    }
  }

  /** A table with a row for each engine; ticking an engine calls `onshow(engine, shown)`. */
  class Readout {
    constructor(scene, onshow) {
      this.scene = scene;
      this.numbers = scene.highest > 0 ? HIGH : FLAT;
      this.caption = make("caption");
      this.rows = new Map();
      this.boxes = new Map();
      this.swatches = [];
      const body = make("tbody");
      for (const engine of scene.engines) body.append(...this.rowsOf(engine, onshow));
      const heads = ["engine", ...this.numbers, ...WORDS].map((text) =>
        make("th", { scope: "col", textContent: text }));
      this.element = make("table", { className: "gb-readout" },
        this.caption, make("thead", {}, make("tr", {}, ...heads)), body);
    }

    /** Makes the row of an engine and, if there are remarks, a row below with its outcome. */
    rowsOf(engine, onshow) {
      const swatch = make("canvas", { className: "gb-swatch" });
      swatch.setAttribute("aria-hidden", "true");
      this.swatches.push([swatch, engine]);
      const box = make("input", {
        type: "checkbox", checked: engine.shown, disabled: !engine.motion,
      });
      box.addEventListener("change", () => onshow(engine, box.checked));
      this.boxes.set(engine, box);
      const name = make("label", { className: "gb-engine" }, box, swatch,
        make("span", { textContent: engine.name }));
      const row = make("tr", {}, make("th", { scope: "row" }, name));
      if (!engine.motion) {
        row.append(make("td", {
          colSpan: this.numbers.length + WORDS.length, className: "gb-words",
          textContent: this.absenceWords(engine),
        }));
        return [row];
      }
      const cells = this.numbers.map(() => make("td"));
      const end = make("td");
      row.append(...cells, end,
        make("td", { textContent: engine.divergence === null ? "–" : timeWords(engine.divergence) }));
      this.rows.set(engine, [...cells, end]);
      const fate = this.fateWords(engine);
      if (!fate) return [row];
      const words = make("td", {
        colSpan: 1 + this.numbers.length + WORDS.length, className: "gb-words",
      }, make("div", { textContent: fate }));
      return [row, make("tr", { className: "gb-fate" }, words)];
    }

    absenceWords(engine) {
      if (engine.outcome === "ran" && !engine.reason) return "recorded no motion";
      return [engine.outcome.replaceAll("-", " "), engine.reason].filter(Boolean).join(": ");
    }

    /** Returns the outcome of an engine that ran, in words. */
    fateWords(engine) {
      const words = [];
      if (engine.verdict) words.push(engine.verdict);
      if (engine.status && engine.status !== "rest") words.push(`ended: ${engine.status}`);
      if (engine.horizon !== null) words.push(`horizon ${timeWords(engine.horizon)}`);
      for (const [ball, t] of engine.motion.lost) {
        words.push(
          `ball ${this.scene.balls[ball].id} is lost after ${timeWords(t)}: not finite, or too far away`);
      }
      return words.join("; ");
    }

    /** Formats a distance. Each path has an error up to the tolerance, so smaller values are "<". */
    offWords(metres) {
      const least = 2 * this.scene.tolerance;
      return metres < least ? `< ${millimetres(least)}` : millimetres(metres);
    }

    setShown(engine, shown) {
      engine.shown = shown;
      this.boxes.get(engine).checked = shown;
    }

    show(t, ball, reference) {
      const base = reference.tracks[ball].at(t);
      const truth = this.scene.truth?.rest[ball];
      const caption = `Ball ${this.scene.balls[ball].id} at ${timeWords(t)}; ` +
        `distance: from the position in ${reference.name}`;
      if (this.caption.textContent !== caption) this.caption.textContent = caption;
      for (const [engine, cells] of this.rows) {
        const track = engine.tracks[ball];
        const place = track.at(t);
        const rest = engine.rest?.[ball];
        const off = place && base && engine !== reference
          ? this.offWords(Math.hypot(place[0] - base[0], place[1] - base[1]))
          : "–";
        const said = [
          off,
          place ? millimetres(place[0]) : "–",
          place ? millimetres(place[1]) : "–",
          ...(this.numbers === HIGH ? [place ? millimetres(place[2]) : "–"] : []),
          PHASE_WORDS[track.phaseAt(t)],
          rest && truth
            ? standingWords(engine, Math.hypot(rest[0] - truth[0], rest[1] - truth[1]))
            : "–",
        ];
        said.forEach((text, i) => {
          if (cells[i].textContent !== text) cells[i].textContent = text;
        });
      }
    }

    /** Draws the line and the sign of each engine, in the current colours of the page. */
    drawSwatches(plate, draw) {
      for (const [canvas, engine] of this.swatches) {
        draw(canvas, 40, (context) => {
          context.strokeStyle = context.fillStyle = css(plate.colourOf(engine));
          context.lineWidth = engine.ours ? 4.5 : 1.8;
          context.setLineDash(engine.dash.map((part) => 1.4 * part));
          context.beginPath();
          context.moveTo(0, 8);
          context.lineTo(40, 8);
          context.stroke();
          context.setLineDash([]);
          if (!engine.ours) drawMarker(context, engine.marker, 20, 8, 5);
        });
      }
    }
  }

  Object.assign(Ghostball, { Readout, distanceWords });
})();
