"use strict";
// Base and head of one scene: beside each other, and over each other with a wipe.
globalThis.Ghostball ??= {};

(() => {
  const { Plate, Player, css, decode, distanceWords, iconButton, make, timeWords } = Ghostball;
  const SIDES = ["base", "head"];
  const SAY_EVERY = 100; // [ms] while it plays: nobody listens faster
  const SKIN = 0.3; // how much of the other side shines through, over the whole

  /** Both sides as one engine each, base as outlines and head filled, on one clock. */
  class Comparison {
    constructor(root, scene, sides) {
      this.root = root;
      this.scene = scene;
      this.sides = sides; // {base, head}: engines with `positions(t)`
      this.duration = Math.max(...SIDES.map((side) => sides[side].end));
      this.player = new Player(this.duration, () => this.update());
      this.wipe = 0.5;
      this.build();
      this.player.seek(this.duration);
    }

    get time() {
      return this.player.time;
    }

    build() {
      const views = [
        this.view("Expected (base)", ["base"]),
        this.view("Actual (head)", ["head"]),
        this.view("Difference", SIDES),
      ];
      this.plates = views.map(([plate]) => plate);
      this.difference = make("p", { className: "gb-said", role: "status" });
      const sides = "Wipe: base to the left, head to the right";
      const wipe = this.slider(sides, 0, 1, this.wipe, (value) => {
        this.wipe = value;
        this.wiper.setAttribute("aria-valuetext", `${Math.round(100 * value)} % base`);
        this.plates[2].draw();
      });
      this.wiper = wipe;
      wipe.setAttribute("aria-valuetext", "50 % base");
      const onion = views[2][1];
      const look = make("button", { type: "button" }, "Look at the largest difference");
      look.addEventListener("click", () => this.lookAtLargest());
      onion.append(make("label", { className: "gb-wipe" }, "Wipe ", wipe), look);
      this.root.replaceChildren(
        make("div", { className: "gb-sides" }, views[0][1], views[1][1]), onion,
        ...(this.duration > 0 ? [this.timeRow()] : []), this.difference);
      for (const plate of this.plates) plate.resize();
    }

    view(title, sides) {
      const stage = make("div", { className: "gb-stage" });
      const plate = new Plate(stage, this.scene, (one) => this.paint(one, sides));
      plate.canvas.setAttribute("role", "img");
      plate.canvas.setAttribute("aria-label", `${title}: ${this.scene.scene}`);
      // One view for all: a millimetre is found on one and compared on the others.
      plate.onview = () => this.share(plate);
      const zoom = make("div", { className: "gb-zoom" },
        iconButton("closer", "Closer", () => plate.zoom(1.6)),
        iconButton("farther", "Farther", () => plate.zoom(1 / 1.6)),
        iconButton("whole", "Whole table", () => plate.reset()));
      return [plate, make("figure", {}, make("figcaption", {}, title, zoom), stage)];
    }

    share(from) {
      for (const plate of this.plates) {
        if (plate === from || !plate.view) continue;
        const scale = from.view.scale * (plate.whole().scale / from.whole().scale);
        plate.view = { ...from.view, scale };
        plate.fitted = from.fitted;
        plate.canvas.classList.toggle("gb-closer", !plate.fitted);
        plate.draw();
      }
    }

    slider(label, min, max, value, act) {
      const slider = make(
        "input", { type: "range", className: "gb-slider", min, max, step: "any", value });
      slider.setAttribute("aria-label", label);
      slider.addEventListener("input", () => act(Number(slider.value)));
      return slider;
    }

    timeRow() {
      this.clock = make("span", { className: "gb-clock" });
      this.timer = this.slider("Time of both sides", 0, this.duration, this.time, (t) =>
        this.player.go(t));
      return make("div", { className: "gb-controls" }, this.player.button, this.timer, this.clock);
    }

    paint(plate, sides) {
      if (sides.length === 1) {
        this.side(plate, sides[0]);
        return;
      }
      const { context, width, height } = plate;
      const edge = this.wipe * width;
      const clipped = (left, right, side, other) => {
        context.save();
        context.beginPath();
        context.rect(left, 0, right - left, height);
        context.clip();
        context.globalAlpha = SKIN;
        this.side(plate, other);
        context.globalAlpha = 1;
        this.side(plate, side);
        context.restore();
      };
      clipped(0, edge, "base", "head");
      clipped(edge, width, "head", "base");
      this.joins(plate);
      context.strokeStyle = css(plate.theme.accent);
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(edge, 0);
      context.lineTo(edge, height);
      context.stroke();
    }

    side(plate, side) {
      const engine = this.sides[side];
      if (engine.tracks.length) plate.drawTrails(engine, this.time);
      plate.drawBalls(engine, this.time, { filled: side === "head" });
    }

    /** From where base has a ball to where head has it. */
    joins(plate) {
      const { context } = plate;
      const [base, head] = SIDES.map((side) => this.sides[side].positions(this.time));
      context.strokeStyle = css(plate.theme.accent);
      context.lineWidth = 2;
      context.beginPath();
      base.forEach((place, ball) => {
        if (!place || !head[ball]) return;
        context.moveTo(...plate.toPixels(...place));
        context.lineTo(...plate.toPixels(...head[ball]));
      });
      context.stroke();
    }

    update() {
      for (const plate of this.plates) plate.draw();
      const words = `${timeWords(this.time)} of ${timeWords(this.duration)}`;
      if (this.timer) {
        this.timer.value = this.time;
        this.clock.textContent = words;
      }
      const { playing } = this.player;
      const now = performance.now();
      if (playing && now - (this.saidAt ?? 0) < SAY_EVERY) return;
      this.saidAt = now;
      this.timer?.setAttribute("aria-valuetext", words);
      // Read aloud once it stands still: else a screen reader would talk without end.
      this.difference.setAttribute("aria-live", playing ? "off" : "polite");
      this.difference.textContent = this.differenceWords();
    }

    /** The ball that differs most now, and by how much [m]; -1 where none is on both sides. */
    largest() {
      const [base, head] = SIDES.map((side) => this.sides[side].positions(this.time));
      let [largest, which] = [-1, -1];
      base.forEach((place, ball) => {
        if (!place || !head[ball]) return;
        const off = Math.hypot(place[0] - head[ball][0], place[1] - head[ball][1]);
        if (off > largest) [largest, which] = [off, ball];
      });
      return [largest, which];
    }

    /** Looks at the ball that differs most, so close that the difference fills the plates. */
    lookAtLargest() {
      const [largest, which] = this.largest();
      if (which < 0) return;
      const [base, head] = SIDES.map((side) => this.sides[side].positions(this.time)[which]);
      const middle = [(base[0] + head[0]) / 2, (base[1] + head[1]) / 2];
      this.plates[2].lookAt(middle, 4 * largest);
    }

    differenceWords() {
      const [largest, which] = this.largest();
      if (which < 0) return "No ball has a position on both sides.";
      const least = this.duration > 0 ? 2 * this.scene.tolerance : 0;
      if (largest <= least) {
        return least
          ? `No ball differs by more than ${distanceWords(least)} here.`
          : "No ball differs.";
      }
      return `Largest difference: ball ${this.scene.balls[which].id}, ${distanceWords(largest)}.`;
    }

    destroy() {
      this.player.stop();
      for (const plate of this.plates) plate.destroy();
      this.root.replaceChildren();
    }
  }

  const STILL = { dash: [], marker: "s", motion: { phases: false }, tracks: [], end: 0 };
  const COLOURS = { base: "#0072B2", head: "#D55E00" };

  function dressed(engine, side) {
    return Object.assign(engine, {
      colour: COLOURS[side],
      ours: side === "head",
      dash: side === "base" ? [5, 2.5] : [],
    });
  }

  /** Rest positions alone, as an engine that never moves. */
  function still(rest, side) {
    const places = rest.map((place) => (place ? [place[0], place[1]] : null));
    return dressed({ ...STILL, positions: () => places }, side);
  }

  async function readSides(given) {
    if (given.base && given.head) {
      const scenes = await Promise.all(SIDES.map((side) => decode(given[side])));
      const engines = scenes.map((scene, i) => {
        const engine = scene.engines.find((one) => one.motion);
        if (!engine) throw new Error(`${SIDES[i]} has no recorded motion`);
        return dressed(engine, SIDES[i]);
      });
      const views = scenes.map((scene) => scene.view);
      const view = [Math.min, Math.max, Math.min, Math.max].map((pick, edge) =>
        pick(...views.map((one) => one[edge])));
      const scene = { ...scenes[1], view, engines };
      return [scene, { base: engines[0], head: engines[1] }];
    }
    const sides = { base: still(given.rest_base, "base"), head: still(given.rest_head, "head") };
    return [{ ...given.scene, engines: Object.values(sides) }, sides];
  }

  /**
   * Shows base and head of a scene. Takes {base, head}, both as `scene_data` or `motion_data` give
   * them; or {scene, rest_base, rest_head}: the data of the scene, and [[x, y], ...] in metres.
   */
  Ghostball.mountCompare = function mountCompare(element, given) {
    element.classList.add("gb-replay", "gb-compare");
    let comparison = null;
    let gone = false;
    const handle = {
      seek: (t) => comparison?.player.go(t),
      get time() { return comparison?.time ?? 0; },
      get duration() { return comparison?.duration ?? 0; },
      engines: SIDES,
      positions: (side) => comparison?.sides[side]?.positions(comparison.time) ?? null,
      destroy() {
        gone = true;
        comparison?.destroy();
        element.classList.remove("gb-replay", "gb-compare");
        delete element.ghostball;
      },
    };
    element.ghostball = handle;
    element.replaceChildren(make("p", { textContent: "Reading both sides …" }));
    handle.ready = readSides(given).then(
      ([scene, sides]) => {
        if (!gone) comparison = new Comparison(element, scene, sides);
      },
      (error) => element.replaceChildren(make("p", { textContent:
        `Base and head can't be shown: ${error.message}.` })),
    );
    return handle;
  };
})();
