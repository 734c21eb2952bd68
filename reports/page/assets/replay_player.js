"use strict";
// The clock of a replay: where it is, whether it runs, how fast.
globalThis.Ghostball ??= {};

(() => {
  const { icon, iconButton, relabel } = Ghostball;

  /** `onchange()` is called whenever the time, or whether it plays, has changed. */
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

    /** Goes to an instant [s]; what plays continues from there. */
    seek(t) {
      this.time = Math.min(Math.max(Number(t) || 0, 0), this.duration);
      this.onchange();
    }

    /** Goes to an instant as somebody asked for it: what plays stops. */
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
