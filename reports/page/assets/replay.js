"use strict";
// The replay of one scene at any time: Ghostball's engine and one or more ticked engines.
globalThis.Ghostball ??= {};

(() => {
  const {
    EventList, Plate, Player, Readout, SideView, Timeline, choice, decode, drawSmall, help, iconButton,
    legend, make, tick, timeWords,
  } = Ghostball;
  const SPEEDS = [0.01, 0.03, 0.1, 0.25, 0.5, 1, 2, 4];
  const MANY_BALLS = 5; // with this many balls or more, full paths of several engines are unreadable
  const TAIL = 1; // [s] of path behind a ball
  const QUIET = 600; // [ms] without a change before screen readers get the status
  const READOUT_EVERY = 100; // [ms] between updates of the table while playing
  const SAID = 4; // most simultaneous events in the status
  const SCROLLS = [" ", "ArrowLeft", "ArrowRight", "Home", "End"];

  class Replay {
    constructor(root, scene, { share } = {}) {
      this.root = root;
      this.scene = scene;
      this.share = share;
      this.ran = scene.engines.filter((engine) => engine.motion);
      this.player = new Player(scene.duration, () => this.update());
      this.ball = 0;
      this.trails = scene.balls.length < MANY_BALLS ? "all" : "tails";
      this.names = true;
      this.stripes = true;
      this.reference = this.ran.find((engine) => engine.ours) ?? this.ran[0];
      // Paths of many engines are unreadable: at first only the reference and one more are shown.
      const other = this.ran.find((engine) => engine !== this.reference);
      for (const engine of this.ran) engine.shown = engine === this.reference || engine === other;
      this.build();
      this.gone = new AbortController();
      root.addEventListener("keydown", (event) => this.key(event), { signal: this.gone.signal });
      this.chooseLog(this.reference);
      this.player.seek(0);
    }

    get time() {
      return this.player.time;
    }

    build() {
      const { scene, root } = this;
      const stage = make("div", { className: "gb-stage", tabIndex: 0, role: "group" });
      stage.setAttribute(
        "aria-label",
        `Replay of ${scene.scene}: ${scene.balls.length} balls, ${this.ran.length} engines. ` +
          "Space plays; arrows move in time; n and p go to events.",
      );
      this.plate = new Plate(stage, scene, (plate) => this.paint(plate));
      this.plate.onview = () => this.zoomed();
      this.side = scene.highest > 0 ? new SideView(stage, this.plate) : null;
      this.clock = make("span", { className: "gb-clock" });
      const line = make("div", { className: "gb-line" });
      this.timeline = new Timeline(line, this.plate, scene.duration, (t) => this.player.go(t));
      this.events = new EventList(scene, this.ran, {
        onchoose: (engine) => this.chooseLog(engine),
        onjump: (t) => this.player.go(t),
      });
      const controls = this.controlRow();
      this.status = make("p", { className: "gb-said", role: "status" });
      this.status.setAttribute("aria-live", "polite");
      root.replaceChildren(
        stage, line, this.legend(), controls, this.status, this.jumps(),
        this.readoutBox(),
        make("div", { className: "gb-panels" }, this.events.element, help(this.scene)),
      );
      this.sizes = new ResizeObserver(() => this.timeline.drawMarks());
      this.sizes.observe(line);
      this.plate.resize();
    }

    zoomButtons() {
      this.whole = iconButton("whole", "Whole table", () => this.plate.reset(), "0");
      this.whole.disabled = true;
      return make("div", { className: "gb-zoom" },
        iconButton("closer", "Zoom in", () => this.plate.zoom(1.6), "+"),
        iconButton("farther", "Zoom out", () => this.plate.zoom(1 / 1.6), "-"),
        this.whole,
        iconButton("ball", "Zoom to the selected ball", () => this.lookAtBall(), "b"));
    }

    controlRow() {
      const speeds = SPEEDS.map((speed) => [speed, `${speed}×`]);
      const [speedLabel, speedList] = choice("Speed", speeds, 1, (value) => this.setSpeed(Number(value)));
      this.speeds = speedList;
      const draw = () => this.plate.draw();
      const kinds = [
        ["all", "all"], ["tails", "the last second"], ["one", "one engine"], ["none", "none"],
      ];
      const [trailLabel] = choice("Trails", kinds, this.trails, (value) => {
        this.trails = value;
        draw();
      });
      return make("div", { className: "gb-controls" },
        iconButton("start", "To the start", () => this.player.go(0), "Home"),
        iconButton("back", "Previous event", () => this.step(-1), "p"),
        this.player.button,
        iconButton("next", "Next event", () => this.step(1), "n"),
        iconButton("end", "To the end", () => this.player.go(this.scene.duration), "End"),
        this.zoomButtons(), this.clock, speedLabel, trailLabel,
        tick("Names", this.names, (on) => {
          this.names = on;
          draw();
        }),
        tick("Stripes", this.stripes, (on) => {
          this.stripes = on;
          draw();
        }),
        ...(this.share ? [this.linkButton()] : []));
    }

    linkButton() {
      const button = this.button("Copy link", "Copy a link to this time and these engines",
        () => this.share(button, this.view));
      return button;
    }

    /** The view that a link stores: time and shown engines. */
    get view() {
      return { t: this.time, engines: this.ran.filter((one) => one.shown).map((one) => one.label) };
    }

    /** Shows a view: time and engines. Values that are missing or unknown change nothing. */
    look({ t, engines = [] }) {
      if (this.ran.some((one) => engines.includes(one.label))) {
        for (const one of this.ran) this.readout.setShown(one, engines.includes(one.label));
        const last = this.ran.findLast((one) => one.shown);
        this.chooseLog(last);
        this.plate.draw();
      }
      if (Number.isFinite(t)) this.player.go(t);
    }

    button(text, label, act) {
      const button = make("button", { type: "button", textContent: text });
      if (label) button.setAttribute("aria-label", label);
      button.addEventListener("click", act);
      return button;
    }

    /** Makes buttons that jump to the first wrong collision of each engine, and to the horizon. */
    jumps() {
      const jumps = make("div", { className: "gb-jumps" });
      const parted = this.ran
        .filter((engine) => engine.divergence !== null)
        .sort((p, q) => p.divergence - q.divergence);
      this.firstParting = parted[0]?.divergence ?? null;
      if (parted.length) {
        const first = parted[0];
        jumps.append(this.button(
          `Jump to first wrong collision: ${first.name}, ${timeWords(first.divergence)}`,
          `Jump to the first wrong collision, of ${first.name} at ${timeWords(first.divergence)}`,
          () => this.jump(first)));
      }
      if (this.scene.horizon !== null && this.scene.horizon <= this.scene.duration) {
        jumps.append(this.button(
          `Horizon of double precision: ${timeWords(this.scene.horizon)}`,
          "Jump to the horizon: after it, double precision can't determine where the balls are",
          () => this.player.go(this.scene.horizon)));
      }
      const rest = parted.slice(1).map((engine) => {
        const button = this.button(
          `${engine.name} ${timeWords(engine.divergence)}`,
          `Jump to the first wrong collision of ${engine.name} at ${timeWords(engine.divergence)}`,
          () => this.jump(engine));
        return make("li", {}, button);
      });
      if (rest.length) {
        jumps.append(make("details", {},
          make("summary", {}, rest.length === 1
            ? "1 more engine has wrong collisions"
            : `${rest.length} more engines have wrong collisions`),
          make("ul", {}, ...rest)));
      }
      jumps.hidden = jumps.childElementCount === 0;
      return jumps;
    }

    jump(engine) {
      this.showEngine(engine, true);
      this.chooseLog(engine);
      this.player.go(engine.divergence);
    }

    showEngine(engine, shown) {
      this.readout.setShown(engine, shown);
      this.plate.draw();
      this.mark();
    }

    readoutBox() {
      this.readout = new Readout(this.scene, (engine, shown) => this.showEngine(engine, shown));
      const balls = this.scene.balls.map((ball, i) => [i, ball.id]);
      const [ballLabel, ballList] = choice("Ball", balls, 0, (value) => this.chooseBall(Number(value)));
      this.balls = ballList;
      const engines = this.ran.map((engine, i) => [i, engine.name]);
      const [againstLabel] = choice("against", engines, this.ran.indexOf(this.reference), (value) => {
        this.reference = this.ran[Number(value)];
        this.update();
      });
      const showAll = (wanted) => {
        for (const engine of this.ran) this.readout.setShown(engine, wanted(engine));
        this.plate.draw();
        this.mark();
      };
      const scroll = make("div", { className: "gb-scroll", tabIndex: 0, role: "region" }, this.readout.element);
      scroll.setAttribute("aria-label", "Engines, and the selected ball's position in each");
      return make("fieldset", { className: "gb-numbers" }, make("legend", { textContent: "Engines" }),
        make("div", { className: "gb-choices" }, ballLabel, againstLabel,
          this.button("Show all", "", () => showAll(() => true)),
          this.button("Only this one", "Show only the engine that the others are compared with",
            () => showAll((engine) => engine === this.reference))),
        scroll);
    }

    chooseBall(ball) {
      this.ball = ball;
      this.balls.value = ball;
      this.update();
    }

    legend() {
      const { list, signs } = legend(this.ran, this.scene.truth, this.timeline.lanes.length);
      this.signs = signs;
      return list;
    }

    /** Draws the lines and signs of the legend, in the current colours of the page. */
    drawSigns() {
      const { theme } = this.plate;
      for (const [canvas, paint] of this.signs) drawSmall(canvas, 28, theme, paint);
      this.readout.drawSwatches(this.plate, (canvas, width, paint) =>
        drawSmall(canvas, width, theme, paint));
    }

    paint(plate) {
      if (this.drawnTheme !== plate.theme) {
        this.drawnTheme = plate.theme;
        this.drawSigns();
        this.timeline.drawMarks();
      }
      const shown = this.ran.filter((engine) => engine.shown);
      const order = [...shown].sort((p, q) => Number(q.ours) - Number(p.ours)); // Ghostball's engine first, beneath
      for (const engine of order) {
        if (this.trails === "none" || (this.trails === "one" && engine !== this.reference)) continue;
        plate.drawTrails(engine, this.time, this.trails === "tails" ? this.time - TAIL : 0);
      }
      if (this.scene.truth) plate.drawTruth(this.scene.truth.rest);
      const { names, stripes } = this;
      for (const engine of order) plate.drawShadows(engine, this.time);
      for (const engine of order) plate.drawBalls(engine, this.time, { names, stripes });
      const place = this.reference.tracks[this.ball].at(this.time);
      if (place) plate.drawChosen(place, this.ball);
      if (this.side) this.paintSide(order, place);
    }

    /** Paints the side view, with the path of the selected ball. */
    paintSide(order, place) {
      const { side } = this;
      side.begin(place ? place[0] : side.middle ?? 0);
      side.drawCloth();
      for (const engine of order) side.drawTrail(engine, this.ball, this.time);
      for (const engine of order) side.drawBalls(engine, this.time, this.stripes);
    }

    zoomed() {
      this.whole.disabled = this.plate.fitted;
    }

    lookAtBall() {
      const place = this.reference.tracks[this.ball].at(this.time);
      const ball = 8 * this.scene.balls[this.ball].radius;
      if (place) this.plate.lookAt(place, Math.min(ball, this.plate.span));
    }

    chooseLog(engine) {
      this.events.show(engine);
      this.mark();
      this.update();
    }

    /** Marks events, the first wrong collision of each shown engine, and the horizon. */
    mark() {
      const flags = this.ran
        .filter((engine) => engine.shown && engine.divergence !== null)
        .map((engine) => ({ t: engine.divergence, engine }))
        .sort((p, q) => q.t - p.t); // the first one last, on top
      if (flags.length) flags[flags.length - 1].text = "first wrong collision";
      const { horizon, duration } = this.scene;
      if (horizon !== null && horizon <= duration) flags.push({ t: horizon, text: "horizon" });
      this.timeline.show(this.scene.kinds, this.events.engine.log, flags);
    }

    update() {
      this.timeline.setTime(this.time);
      this.clock.textContent = `${timeWords(this.time)} of ${timeWords(this.scene.duration)}`;
      this.plate.draw();
      const now = performance.now();
      if (this.player.playing && now - (this.readAt ?? 0) < READOUT_EVERY) return;
      this.readAt = now;
      this.timeline.say();
      this.readout.show(this.time, this.ball, this.reference);
      this.events.choose(this.time);
      clearTimeout(this.saying);
      if (this.player.playing) this.status.textContent = "";
      else this.saying = setTimeout(() => this.say(), QUIET);
    }

    say() {
      const happens = this.events.wordsAt(this.time).slice(0, SAID);
      const what = happens.length ? `: ${happens.join(", ")}` : "";
      this.status.textContent = `t = ${timeWords(this.time)}${what} (${this.events.engine.name})`;
    }

    /** Goes to the time of the next (or previous) event in the chosen log. */
    step(direction) {
      const t = this.events.beside(this.time, direction);
      if (t !== undefined) this.player.go(t);
    }

    setSpeed(speed) {
      this.player.speed = speed;
      this.speeds.value = speed;
    }

    key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const tag = event.target.tagName;
      const typing = tag === "SELECT";
      const little = event.shiftKey ? 1e-3 : 1e-2;
      const speedAt = SPEEDS.indexOf(this.player.speed);
      const acts = {
        " ": () => this.player.toggle(),
        ArrowLeft: () => this.player.go(this.time - little * this.scene.duration),
        ArrowRight: () => this.player.go(this.time + little * this.scene.duration),
        Home: () => this.player.go(0),
        End: () => this.player.go(this.scene.duration),
        n: () => this.step(1),
        p: () => this.step(-1),
        d: () => this.firstParting !== null && this.player.go(this.firstParting),
        "[": () => this.setSpeed(SPEEDS[Math.max(speedAt - 1, 0)]),
        "]": () => this.setSpeed(SPEEDS[Math.min(speedAt + 1, SPEEDS.length - 1)]),
        "+": () => this.plate.zoom(1.6),
        "=": () => this.plate.zoom(1.6),
        "-": () => this.plate.zoom(1 / 1.6),
        0: () => this.plate.reset(),
        b: () => this.lookAtBall(),
      };
      const act = acts[event.key];
      // Lists handle all keys, buttons and boxes handle Space, scrolling elements the scrolling keys.
      if (!act || typing) return;
      if (SCROLLS.includes(event.key) && event.target.classList.contains("gb-scroll")) return;
      if (event.key === " " && (tag === "BUTTON" || tag === "SUMMARY" || event.target.type === "checkbox")) return;
      event.preventDefault();
      act();
    }

    destroy() {
      this.player.stop();
      clearTimeout(this.saying);
      this.gone.abort();
      this.sizes.disconnect();
      this.plate.destroy();
      this.root.replaceChildren();
    }
  }

  /**
   * Decodes the data of a scene's replay and puts the replay into an element.
   *
   * The promise `element.ghostball.ready` is fulfilled once the replay is in the element. Then
   * `element.ghostball` has {seek(t), time, positions(label), orientations(label), engines,
   * duration, look({t, engines}), view, key(event)}. If `options.share(button, view)` is given, a
   * button copies a link.
   */
  Ghostball.mountReplay = function mountReplay(element, data, options = {}) {
    element.classList.add("gb-replay");
    let replay = null;
    let gone = false;
    const handle = {
      seek: (t) => replay?.player.go(t),
      look: (view) => replay?.look(view),
      key: (event) => replay?.key(event),
      get view() { return replay?.view ?? null; },
      get time() { return replay?.time ?? 0; },
      get duration() { return replay?.scene.duration ?? 0; },
      get playing() { return replay?.player.playing ?? false; },
      engines: data.engines.map((engine) => engine.label),
      positions: (label) => replay?.ran
        .find((engine) => engine.label === label)
        ?.positions(replay.time) ?? null,
      orientations: (label) => replay?.ran
        .find((engine) => engine.label === label)
        ?.tracks.map((track) => track.orientation(replay.time)) ?? null,
      destroy() {
        gone = true;
        replay?.destroy();
        element.classList.remove("gb-replay");
        delete element.ghostball;
      },
    };
    element.ghostball = handle;
    if (!data.engines.some((engine) => engine.motion)) {
      element.replaceChildren(make("p", { textContent:
        "No engine recorded its motion in this scene, so there is nothing to replay." }));
      handle.ready = Promise.resolve();
      return handle;
    }
    element.replaceChildren(make("p", { textContent: "Reading the motion …" }));
    handle.ready = decode(data).then(
      (scene) => {
        if (!gone) replay = new Replay(element, scene, options);
      },
      (error) => element.replaceChildren(make("p", { textContent:
        `This motion can't be replayed: ${error.message}.` })),
    );
    return handle;
  };
})();
