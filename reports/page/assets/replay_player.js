"use strict";
// The clock of a replay: its time, whether it runs, and its speed.
globalThis.Ghostball ??= {};

(() => {
  const { icon, iconButton, relabel } = Ghostball;

  /** Calls `onchange()` whenever the time changes and whenever playing starts or stops. */
  class Player {
    constructor(duration, onchange) {
      this.duration = duration;
      this.onchange = onchange;
      this.time = 0;
      this.speed = 1;
      this.playing = false;
      this.button = iconButton("play", "Play", () => this.toggle(), "Space");
      this.button.classList.add("gb-play");
    }

    /** Goes to time t [s]; a playing replay continues from there. */
    seek(t) {
      this.time = Math.min(Math.max(Number(t) || 0, 0), this.duration);
      this.onchange();
    }

    /** Goes to time t at the user's request: a playing replay stops. */
    go(t) {
      this.stop();
      this.seek(t);
    }

    toggle() {
      if (this.playing) this.go(this.time);
      else this.start();
    }

    start() {
      if (this.time >= this.duration) this.seek(0);
      this.playing = true;
      this.label();
      let before = performance.now();
      const frame = (now) => {
        if (!this.playing) return;
        const t = this.time + (Math.max(now - before, 0) / 1000) * this.speed;
        before = now;
        if (t >= this.duration) this.stop();
        this.seek(t);
        if (this.playing) this.frame = requestAnimationFrame(frame);
      };
      this.frame = requestAnimationFrame(frame);
    }

    stop() {
      this.playing = false;
      cancelAnimationFrame(this.frame);
      this.label();
    }

    label() {
      const name = this.playing ? "Pause" : "Play";
      if (this.button.getAttribute("aria-label") === name) return;
      this.button.replaceChildren(icon(name.toLowerCase()));
      relabel(this.button, name, "Space");
    }
  }

  Object.assign(Ghostball, { Player });
})();
