"use strict";
// The replay of one scene: all engines over each other, at any instant.
globalThis.Ghostball ??= {};

(() => {
  const { Plate, Readout, Timeline, css, decode, drawKind, drawMarker, eventWords, make, timeWords } =
    Ghostball;
  const SPEEDS = [0.01, 0.03, 0.1, 0.25, 0.5, 1, 2, 4];
  const CROWD = 5; // from this many balls on, only ours and one other are shown at first
  const QUIET = 600; // [ms] that nothing changes before the status is said
  const READOUT_EVERY = 100; // [ms] while it plays: nobody reads faster
  const KIND_WORDS = ["balls collide", "cushion", "starts to roll", "comes to rest"];
  const KEYS = [
    ["Space", "play or pause"],
    ["← →", "a hundredth of the run back, on; with Shift a thousandth"],
    ["Home End", "start, end"],
    ["p n", "event before, next event"],
    ["d", "first divergence"],
    ["[ ]", "slower, faster"],
    ["+ − 0", "closer, farther, whole table"],
    ["drag, wheel, pinch", "move and zoom; the wheel once the replay has the focus"],
  ];

  class Replay {
    constructor(root, scene) {
      this.root = root;
      this.scene = scene;
      this.ran = scene.engines.filter((engine) => engine.motion);
      this.time = 0;
      this.playing = false;
      this.speed = 1;
      this.ball = 0;
      this.trails = true;
      this.names = true;
      this.reference = this.ran.find((engine) => engine.ours) ?? this.ran[0];
      this.logged = this.reference;
      if (scene.balls.length >= CROWD) this.showFew();
      this.build();
      this.gone = new AbortController();
      root.addEventListener("keydown", (event) => this.key(event), { signal: this.gone.signal });
      this.chooseLog(this.logged);
      this.seek(0);
    }

    /** Crowds: ours, and the engine that parts from the truth first, whatever that is. */
    showFew() {
      const others = this.ran.filter((engine) => engine !== this.reference);
      const parting = (engine) => engine.divergence ?? Infinity;
      const first = others.sort((p, q) => parting(p) - parting(q))[0];
      for (const engine of this.ran) {
        engine.shown = engine === this.reference || engine === first;
      }
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
      stage.append(this.zoomButtons());
      this.clock = make("output", { className: "gb-clock" });
      const line = make("div", { className: "gb-line" });
      this.timeline = new Timeline(line, this.plate, scene.duration, (t) => {
        this.pause();
        this.seek(t);
      });
      const controls = this.controlRow();
      this.status = make("p", { className: "gb-said", role: "status" });
      this.status.setAttribute("aria-live", "polite");
      root.replaceChildren(
        stage, line, controls, this.status, this.jumps(),
        make("div", { className: "gb-panels" },
          this.engineBox(), this.eventBox(), this.readoutBox()),
        this.legend(), this.help(),
      );
      this.sizes = new ResizeObserver(() => this.timeline.drawMarks());
      this.sizes.observe(line);
      this.plate.resize();
    }

    button(text, label, act, key = "") {
      const button = make("button", { type: "button", textContent: text, title: label + (key && ` (${key})`) });
      button.setAttribute("aria-label", label);
      button.addEventListener("click", act);
      return button;
    }

    zoomButtons() {
      this.whole = this.button("⤢", "Whole table", () => this.plate.reset(), "0");
      return make("div", { className: "gb-zoom" },
        this.button("+", "Closer", () => this.plate.zoom(1.6), "+"),
        this.button("−", "Farther", () => this.plate.zoom(1 / 1.6), "−"),
        this.whole,
        this.button("◎", "Look at the chosen ball", () => this.lookAtBall()));
    }

    controlRow() {
      this.play = this.button("▶", "Play", () => this.toggle(), "Space");
      this.play.classList.add("gb-play");
      this.speeds = make("select", {}, ...SPEEDS.map((speed) =>
        make("option", { value: speed, textContent: `${speed}×`, selected: speed === 1 })));
      this.speeds.addEventListener("change", () => this.setSpeed(Number(this.speeds.value)));
      return make("div", { className: "gb-controls" },
        this.button("⏮", "To the start", () => this.go(0), "Home"),
        this.button("◀|", "Event before", () => this.step(-1), "p"),
        this.play,
        this.button("|▶", "Next event", () => this.step(1), "n"),
        this.button("⏭", "To the end", () => this.go(this.scene.duration), "End"),
        make("label", {}, "Speed ", this.speeds),
        this.clock,
        this.tick("Trails", this.trails, (on) => { this.trails = on; }),
        this.tick("Names", this.names, (on) => { this.names = on; }));
    }

    tick(text, checked, act) {
      const box = make("input", { type: "checkbox", checked });
      box.addEventListener("change", () => {
        act(box.checked);
        this.plate.draw();
      });
      return make("label", { className: "gb-tick" }, box, ` ${text}`);
    }

    /** Buttons to where engines first part from the truth, and to the horizon. */
    jumps() {
      const jumps = make("div", { className: "gb-jumps" });
      const parted = this.ran
        .filter((engine) => engine.divergence !== null)
        .sort((p, q) => p.divergence - q.divergence);
      this.firstParting = parted[0]?.divergence ?? null;
      if (parted.length) {
        const first = parted[0];
        jumps.append(this.button(
          `Jump to first divergence: ${first.name}, ${timeWords(first.divergence)}`,
          `Jump to the first divergence, of ${first.name} at ${timeWords(first.divergence)}`,
          () => this.jump(first), "d"));
      }
      const rest = parted.slice(1).map((engine) => {
        const button = this.button(
          `${engine.name} ${timeWords(engine.divergence)}`,
          `Jump to the divergence of ${engine.name} at ${timeWords(engine.divergence)}`,
          () => this.jump(engine));
        return make("li", {}, button);
      });
      if (rest.length) {
        jumps.append(make("details", {},
          make("summary", { textContent: `${rest.length} more ${rest.length === 1 ? "engine parts" : "engines part"} from the true sequence of collisions` }),
          make("ul", {}, ...rest)));
      }
      if (this.scene.horizon !== null && this.scene.horizon <= this.scene.duration) {
        jumps.append(this.button(
          `Horizon of double precision: ${timeWords(this.scene.horizon)}`,
          "Jump to the horizon: past it, double precision can't say where the balls are",
          () => this.go(this.scene.horizon)));
      }
      jumps.hidden = jumps.childElementCount === 0;
      return jumps;
    }

    jump(engine) {
      this.showEngine(engine, true);
      this.chooseLog(engine);
      this.go(engine.divergence);
    }

    engineBox() {
      const box = make("fieldset", { className: "gb-engines" }, make("legend", { textContent: "Engines" }));
      this.boxes = new Map();
      this.swatches = [];
      for (const engine of this.scene.engines) {
        const swatch = make("canvas", { className: "gb-swatch" });
        swatch.setAttribute("aria-hidden", "true");
        this.swatches.push([swatch, engine]);
        const check = make("input", {
          type: "checkbox", checked: engine.shown, disabled: !engine.motion,
        });
        check.addEventListener("change", () => this.showEngine(engine, check.checked));
        this.boxes.set(engine, check);
        box.append(make("label", { className: "gb-engine" }, check, swatch,
          make("span", {}, make("b", { textContent: engine.name }),
            make("small", { textContent: this.stateWords(engine) }))));
      }
      return box;
    }

    /** What became of an engine, in words. */
    stateWords(engine) {
      if (!engine.motion) {
        return engine.outcome === "ran" && !engine.reason
          ? "recorded no motion"
          : `${engine.outcome}: ${engine.reason}`;
      }
      const words = [];
      if (engine.verdict) words.push(engine.verdict);
      if (engine.status && engine.status !== "rest") words.push(`ended: ${engine.status}`);
      if (engine.divergence !== null) words.push(`parts at ${timeWords(engine.divergence)}`);
      if (engine.horizon !== null) words.push(`own horizon ${timeWords(engine.horizon)}`);
      for (const [ball, t] of engine.motion.lost) {
        words.push(`ball ${this.scene.balls[ball].id} lost from ${timeWords(t)} on: no finite position`);
      }
      return words.join("; ");
    }

    showEngine(engine, shown) {
      engine.shown = shown;
      this.boxes.get(engine).checked = shown;
      this.plate.draw();
      this.mark();
    }

    eventBox() {
      this.logs = make("select", {}, ...this.ran.map((engine, i) =>
        make("option", { value: i, textContent: engine.name })));
      this.logs.addEventListener("change", () => this.chooseLog(this.ran[Number(this.logs.value)]));
      this.events = make("select", { className: "gb-events", size: 9 });
      this.events.setAttribute("aria-label", "Events, to jump to");
      this.events.addEventListener("change", () => {
        this.pause();
        this.seek(this.logged.log.t[Number(this.events.value)]);
      });
      this.thinned = make("small");
      return make("fieldset", { className: "gb-log" }, make("legend", { textContent: "Events" }),
        make("label", {}, "of ", this.logs), this.events, this.thinned);
    }

    readoutBox() {
      this.readout = new Readout(this.scene);
      const balls = make("select", {}, ...this.scene.balls.map((ball, i) =>
        make("option", { value: i, textContent: ball.id })));
      balls.addEventListener("change", () => {
        this.ball = Number(balls.value);
        this.update();
      });
      const references = make("select", {}, ...this.ran.map((engine, i) =>
        make("option", { value: i, textContent: engine.name, selected: engine === this.reference })));
      references.addEventListener("change", () => {
        this.reference = this.ran[Number(references.value)];
        this.update();
      });
      this.balls = balls;
      const scroll = make("div", { className: "gb-scroll", tabIndex: 0, role: "region" }, this.readout.element);
      scroll.setAttribute("aria-label", "Positions of the chosen ball");
      return make("fieldset", { className: "gb-numbers" }, make("legend", { textContent: "Position" }),
        make("div", { className: "gb-choices" },
          make("label", {}, "Ball ", balls), make("label", {}, "against ", references)),
        scroll);
    }

    legend() {
      const item = (draw, text) => {
        const sign = make("canvas", { className: "gb-sign" });
        sign.setAttribute("aria-hidden", "true");
        this.signs.push([sign, draw]);
        return make("li", {}, sign, text);
      };
      this.signs = [];
      const list = make("ul", { className: "gb-legend" });
      KIND_WORDS.forEach((text, lane) => list.append(
        item((context) => drawKind(context, lane, 14, 8), text)));
      if (this.ran.some((engine) => engine.motion.phases)) {
        const stroke = (width, alpha) => (context, theme) => {
          context.strokeStyle = css(theme.ink, alpha);
          context.lineWidth = width;
          context.beginPath();
          context.moveTo(2, 8);
          context.lineTo(26, 8);
          context.stroke();
        };
        list.append(item(stroke(4.5, 0.3), "rolls (ours)"), item(stroke(7, 0.6), "slides (ours)"));
      }
      if (this.scene.truth) {
        list.append(item((context, theme) => {
          context.strokeStyle = css(theme.accent);
          context.lineWidth = 1.5;
          context.beginPath();
          context.moveTo(8, 8);
          context.lineTo(20, 8);
          context.moveTo(14, 2);
          context.lineTo(14, 14);
          context.stroke();
        }, `end in truth (${this.scene.truth.kind})`));
      }
      return list;
    }

    help() {
      const list = make("dl");
      for (const [key, what] of KEYS) {
        list.append(make("div", {}, make("dt", { textContent: key }), make("dd", { textContent: what })));
      }
      return make("details", { className: "gb-help" },
        make("summary", { textContent: "Keys, and how exact this is" }), list,
        make("p", { textContent:
          "Paths run within 0.01 mm of the stored samples; between them they are drawn, not computed. " +
          "Times of events and positions at the end are exact. Height is left out." }));
    }

    /** Small pictures of lines and signs, in the colours of the moment. */
    drawSigns() {
      const draw = (canvas, width, paint) => {
        const ratio = globalThis.devicePixelRatio || 1;
        canvas.width = width * ratio;
        canvas.height = 16 * ratio;
        const context = canvas.getContext("2d");
        context.setTransform(ratio, 0, 0, ratio, 0, 0);
        context.fillStyle = css(this.plate.theme.ink);
        paint(context, this.plate.theme);
      };
      for (const [canvas, paint] of this.signs) draw(canvas, 28, paint);
      for (const [canvas, engine] of this.swatches) {
        draw(canvas, 40, (context) => {
          context.strokeStyle = context.fillStyle = css(this.plate.colourOf(engine));
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

    paint(plate) {
      if (this.drawnTheme !== plate.theme) {
        this.drawnTheme = plate.theme;
        this.drawSigns();
        this.timeline.drawMarks();
      }
      const shown = this.ran.filter((engine) => engine.shown);
      const order = [...shown].sort((p, q) => Number(q.ours) - Number(p.ours)); // ours beneath
      if (this.trails) for (const engine of order) plate.drawTrails(engine, this.time);
      if (this.scene.truth) plate.drawTruth(this.scene.truth.rest);
      for (const engine of order) plate.drawBalls(engine, this.time, { names: this.names });
      const place = this.reference.tracks[this.ball].at(this.time);
      if (place) plate.drawChosen(place, this.ball);
    }

    zoomed() {
      this.whole.disabled = this.plate.fitted;
    }

    lookAtBall() {
      const place = this.reference.tracks[this.ball].at(this.time);
      if (place) this.plate.lookAt(place, this.scene.balls[this.ball].radius);
    }

    chooseLog(engine) {
      this.logged = engine;
      this.logs.value = this.ran.indexOf(engine);
      const { log } = engine;
      const options = Array.from({ length: log.count }, (_, i) =>
        make("option", {
          value: i,
          textContent: `${timeWords(log.t[i])}  ${eventWords(this.scene, log.kind[i], log.a[i], log.b[i])}`,
        }));
      this.events.replaceChildren(...options);
      const { of } = engine.motion;
      this.thinned.textContent = of > log.count
        ? `${log.count} of ${of} events, evenly chosen; the others are in the log of the run`
        : `${of} ${of === 1 ? "event" : "events"}`;
      this.mark();
      this.update();
    }

    /** Marks the log, and the divergence and horizon of the engines that are shown. */
    mark() {
      const flags = [];
      if (this.scene.horizon !== null && this.scene.horizon <= this.scene.duration) {
        flags.push({ t: this.scene.horizon, engine: null, horizon: true });
      }
      for (const engine of this.ran) {
        if (!engine.shown) continue;
        if (engine.divergence !== null) flags.push({ t: engine.divergence, engine });
        if (engine.horizon !== null) flags.push({ t: engine.horizon, engine, horizon: true });
      }
      this.timeline.show(this.scene.kinds, this.logged.log, flags);
    }

    seek(t) {
      this.time = Math.min(Math.max(Number(t) || 0, 0), this.scene.duration);
      this.update();
    }

    /** Seeks as somebody asked for it: what plays stops. */
    go(t) {
      this.pause();
      this.seek(t);
    }

    update() {
      this.timeline.setTime(this.time);
      this.clock.textContent = `${timeWords(this.time)} of ${timeWords(this.scene.duration)}`;
      this.plate.draw();
      const now = performance.now();
      if (this.playing && now - (this.readAt ?? 0) < READOUT_EVERY) return;
      this.readAt = now;
      this.readout.show(this.time, this.ball, this.reference);
      this.choose();
      clearTimeout(this.saying);
      if (!this.playing) this.saying = setTimeout(() => this.say(), QUIET);
    }

    /** Chooses in the list the last event that has happened. */
    choose() {
      const { log } = this.logged;
      let at = -1;
      for (let low = 0, high = log.count - 1; low <= high;) {
        const middle = (low + high) >> 1;
        if (log.t[middle] <= this.time) {
          at = middle;
          low = middle + 1;
        } else high = middle - 1;
      }
      const chosen = Number(this.events.value || -1);
      // Of several at one instant, the one that was picked stays.
      if (at < 0) this.events.selectedIndex = -1;
      else if (!(chosen >= 0 && log.t[chosen] === log.t[at])) this.events.selectedIndex = at;
    }

    say() {
      const { log } = this.logged;
      const happens = [];
      for (let i = 0; i < log.count; i++) {
        if (log.t[i] === this.time) happens.push(eventWords(this.scene, log.kind[i], log.a[i], log.b[i]));
      }
      const what = happens.length ? `: ${happens.slice(0, 4).join(", ")}` : "";
      this.status.textContent = `${timeWords(this.time)}${what} (${this.logged.name})`;
    }

    /** To the next instant with an event of the chosen log, or the one before. */
    step(direction) {
      const times = this.logged.log.t;
      const later = Array.prototype.filter.call(times, (t) => (t - this.time) * direction > 0);
      if (later.length) this.go(direction > 0 ? later[0] : later[later.length - 1]);
      else this.pause();
    }

    setSpeed(speed) {
      this.speed = speed;
      this.speeds.value = speed;
    }

    toggle() {
      if (this.playing) this.pause();
      else this.start();
    }

    start() {
      if (this.time >= this.scene.duration) this.seek(0);
      this.playing = true;
      this.label();
      let before = performance.now();
      const frame = (now) => {
        if (!this.playing) return;
        const t = this.time + (Math.max(now - before, 0) / 1000) * this.speed;
        before = now;
        if (t >= this.scene.duration) this.pause();
        this.seek(t);
        if (this.playing) this.frame = requestAnimationFrame(frame);
      };
      this.frame = requestAnimationFrame(frame);
    }

    pause() {
      if (!this.playing) return;
      this.playing = false;
      cancelAnimationFrame(this.frame);
      this.label();
      this.update();
    }

    label() {
      this.play.textContent = this.playing ? "❚❚" : "▶";
      this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
      this.play.title = `${this.playing ? "Pause" : "Play"} (Space)`;
    }

    key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const tag = event.target.tagName;
      const typing = tag === "SELECT";
      const little = event.shiftKey ? 1e-3 : 1e-2;
      const speedAt = SPEEDS.indexOf(this.speed);
      const acts = {
        " ": () => this.toggle(),
        ArrowLeft: () => this.go(this.time - little * this.scene.duration),
        ArrowRight: () => this.go(this.time + little * this.scene.duration),
        Home: () => this.go(0),
        End: () => this.go(this.scene.duration),
        n: () => this.step(1),
        p: () => this.step(-1),
        d: () => this.firstParting !== null && this.go(this.firstParting),
        "[": () => this.setSpeed(SPEEDS[Math.max(speedAt - 1, 0)]),
        "]": () => this.setSpeed(SPEEDS[Math.min(speedAt + 1, SPEEDS.length - 1)]),
        "+": () => this.plate.zoom(1.6),
        "=": () => this.plate.zoom(1.6),
        "-": () => this.plate.zoom(1 / 1.6),
        0: () => this.plate.reset(),
      };
      const act = acts[event.key];
      // Lists take their keys themselves; a button or a box, its Space.
      if (!act || typing) return;
      if (event.key === " " && (tag === "BUTTON" || tag === "SUMMARY" || event.target.type === "checkbox")) return;
      event.preventDefault();
      act();
    }

    destroy() {
      this.pause();
      clearTimeout(this.saying);
      this.gone.abort();
      this.sizes.disconnect();
      this.plate.destroy();
      this.root.replaceChildren();
    }
  }

  /**
   * Puts the replay of a scene into an element; decodes its data only now.
   *
   * `element.ghostball.ready` is kept once it is there: {seek(t), time, positions(label),
   * engines, duration}.
   */
  Ghostball.mountReplay = function mountReplay(element, data) {
    element.classList.add("gb-replay");
    let replay = null;
    let gone = false;
    const handle = {
      seek: (t) => replay?.go(t),
      get time() { return replay?.time ?? 0; },
      get duration() { return replay?.scene.duration ?? 0; },
      get playing() { return replay?.playing ?? false; },
      engines: data.engines.map((engine) => engine.label),
      positions: (label) => replay?.ran
        .find((engine) => engine.label === label)
        ?.positions(replay.time) ?? null,
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
        "No engine has a recorded motion of this scene, so there is nothing to replay." }));
      handle.ready = Promise.resolve();
      return handle;
    }
    element.replaceChildren(make("p", { textContent: "Reading the motion …" }));
    handle.ready = decode(data).then(
      (scene) => {
        if (!gone) replay = new Replay(element, scene);
      },
      (error) => element.replaceChildren(make("p", { textContent:
        `This motion can't be replayed: ${error.message}.` })),
    );
    return handle;
  };
})();
