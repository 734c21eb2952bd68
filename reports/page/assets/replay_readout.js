"use strict";
// The numbers beside the picture: where each engine has a ball, and how far from the reference.
globalThis.Ghostball ??= {};

(() => {
  const { PHASE } = Ghostball;
  const PHASE_WORDS = {
    [PHASE.RESTING]: "rests",
    [PHASE.SLIDING]: "slides",
    [PHASE.ROLLING]: "rolls",
    [PHASE.UNKNOWN]: "–",
    [PHASE.ABSENT]: "lost",
  };
  const HEADS = ["engine", "x [mm]", "y [mm]", "off [mm]", "moves", "end off truth"];

  /** Makes an element with properties and children; text stays text. */
  function make(tag, properties = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(properties)) {
      if (name in element) element[name] = value;
      else element.setAttribute(name, value);
    }
    element.append(...children);
    return element;
  }

  const millimetres = (metres) => (1e3 * metres).toFixed(2);

  /** A distance with a unit that suits it, to three digits. */
  function distanceWords(metres) {
    if (metres === 0) return "0";
    if (metres < 1e-12) return `${metres.toExponential(1)} m`;
    const [unit, size] = [["m", 1], ["mm", 1e-3], ["µm", 1e-6], ["nm", 1e-9], ["pm", 1e-12]].find(
      ([, one]) => metres >= 0.9995 * one,
    );
    return `${Number((metres / size).toPrecision(3))} ${unit}`;
  }

  /** A table with a row for each engine that ran. */
  class Readout {
    constructor(scene) {
      this.scene = scene;
      this.ran = scene.engines.filter((engine) => engine.motion);
      this.caption = make("caption");
      this.rows = new Map();
      const body = make("tbody");
      for (const engine of this.ran) {
        const cells = HEADS.slice(1).map(() => make("td"));
        body.append(make("tr", {}, make("th", { scope: "row", textContent: engine.name }), ...cells));
        this.rows.set(engine, cells);
      }
      const heads = HEADS.map((text) => make("th", { scope: "col", textContent: text }));
      this.heads = heads;
      this.element = make(
        "table", { className: "gb-readout" }, this.caption,
        make("thead", {}, make("tr", {}, ...heads)), body,
      );
    }

    show(t, ball, reference) {
      const base = reference.tracks[ball].at(t);
      const truth = this.scene.truth?.rest[ball];
      this.caption.textContent =
        `Ball ${this.scene.balls[ball].id} at ${Ghostball.timeWords(t)}; ` +
        `off: distance from ${reference.name}`;
      for (const [engine, cells] of this.rows) {
        const place = engine.tracks[ball].at(t);
        const rest = engine.rest?.[ball];
        const said = place
          ? [
            millimetres(place[0]),
            millimetres(place[1]),
            engine === reference || !base
              ? "–"
              : millimetres(Math.hypot(place[0] - base[0], place[1] - base[1])),
            PHASE_WORDS[engine.tracks[ball].phaseAt(t)],
          ]
          : ["–", "–", "–", "lost"];
        said.push(rest && truth
          ? distanceWords(Math.hypot(rest[0] - truth[0], rest[1] - truth[1]))
          : "–");
        said.forEach((text, i) => {
          if (cells[i].textContent !== text) cells[i].textContent = text;
        });
      }
    }
  }

  Object.assign(Ghostball, { Readout, make, distanceWords });
})();
