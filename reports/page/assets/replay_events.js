"use strict";
// The list of an engine's events; choosing an event jumps to its time.
globalThis.Ghostball ??= {};

(() => {
  const { choice, eventWords, make, timeWords } = Ghostball;

  /** Calls `onchoose(engine)` when another log is chosen, `onjump(t)` when an event is chosen. */
  class EventList {
    constructor(scene, ran, { onchoose, onjump }) {
      this.scene = scene;
      this.ran = ran;
      const [label, engines] = choice("of", ran.map((engine, i) => [i, engine.name]), 0,
        (value) => onchoose(ran[Number(value)]));
      this.engines = engines;
      // A native list stays fast with thousands of lines.
      this.list = make("select", { className: "gb-events", size: 10 });
      this.list.setAttribute("aria-label", "Events, to jump to");
      this.list.addEventListener("change", () => onjump(this.engine.log.t[Number(this.list.value)]));
      this.thinned = make("small");
      this.element = make("fieldset", { className: "gb-log" },
        make("legend", { textContent: "Events" }), label, this.list, this.thinned);
    }

    words(i) {
      const { kind, a, b } = this.engine.log;
      return eventWords(this.scene, kind[i], a[i], b[i]);
    }

    show(engine) {
      this.engine = engine;
      this.engines.value = this.ran.indexOf(engine);
      const { log } = engine;
      const { of } = engine.motion;
      this.list.replaceChildren(...Array.from({ length: log.count }, (_, i) =>
        make("option", { value: i, textContent: `${timeWords(log.t[i], 6)}  ${this.words(i)}` })));
      this.thinned.textContent = of > log.count
        ? `${log.count} of ${of} events, evenly sampled; \`ghostball run\` prints them all`
        : `${of} ${of === 1 ? "event" : "events"}`;
    }

    /** Returns the number of events at or before time t. */
    countBy(t) {
      const { log } = this.engine;
      let low = 0;
      let high = log.count;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (log.t[middle] <= t) low = middle + 1;
        else high = middle;
      }
      return low;
    }

    /** Selects the last event at or before t; of simultaneous events, a selected one stays. */
    choose(t) {
      const last = this.countBy(t) - 1;
      const picked = this.list.selectedIndex;
      const times = this.engine.log.t;
      if (last < 0 || picked < 0 || times[picked] !== times[last]) this.list.selectedIndex = last;
    }

    /** Returns the words of all events at exactly time t. */
    wordsAt(t) {
      const found = [];
      for (let i = this.countBy(t) - 1; i >= 0 && this.engine.log.t[i] === t; i--) {
        found.unshift(this.words(i));
      }
      return found;
    }

    /** Returns the time of the next (or previous) event; undefined if there is none. */
    beside(t, direction) {
      const times = this.engine.log.t;
      if (direction > 0) return times[this.countBy(t)];
      let i = this.countBy(t) - 1;
      while (i >= 0 && times[i] === t) i--;
      return times[i];
    }
  }

  Object.assign(Ghostball, { EventList });
})();
