// The page around the replays: one scene at a time, found by name, linked by its fragment.
"use strict";
(() => {
  const PREFIX = "#scene=";
  const scenes = [...document.querySelectorAll(".scene")];
  const links = new Map(
    [...document.querySelectorAll(".scene-list a")].map((link) => [
      link.getAttribute("href").slice(PREFIX.length),
      link,
    ]),
  );
  const filter = document.getElementById("scene-filter");
  const found = document.querySelector(".picker .found");
  const steps = [...document.querySelectorAll(".picker [data-step]")];
  let open = null;
  let replay = null;

  const dataOf = (id) => JSON.parse(document.getElementById(id).textContent);

  // Nothing of a scene's motion is decoded before it comes into view.
  const whenSeen = (element, act) => {
    const observer = new IntersectionObserver((entries) => {
      if (entries.some((entry) => entry.isIntersecting)) {
        observer.disconnect();
        act();
      }
    }, { rootMargin: "200px" });
    observer.observe(element);
    return observer;
  };

  /** A replay that is read once it comes into view; it looks where it is asked to, and can be closed. */
  const replayIn = (element, view, options) => {
    const mine = {
      mounted: null,
      view,
      look(at) {
        this.view = at;
        this.mounted?.ready.then(() => this.mounted.look(at));
      },
      key(event) {
        this.mounted?.key(event);
      },
      close() {
        observer.disconnect();
        this.mounted?.destroy();
      },
    };
    const observer = whenSeen(element, () => {
      mine.mounted = window.Ghostball.mountReplay(element, dataOf(element.dataset.replay), options);
      mine.look(mine.view);
    });
    return mine;
  };

  /** What a fragment asks for: a scene, alone or with an instant and the engines to look at. */
  const asked = () => {
    const whole = decodeURIComponent(location.hash.replace(/%(?![0-9a-f]{2})/gi, "%25"));
    if (!whole.startsWith(PREFIX)) return null;
    if (links.has(whole.slice(PREFIX.length))) return { name: whole.slice(PREFIX.length), view: {} };
    const parts = new URLSearchParams(location.hash.slice(1));
    const t = parts.has("t") ? Number(parts.get("t")) : undefined;
    return { name: parts.get("scene"), view: { t, engines: parts.getAll("engine") } };
  };

  const linkTo = (name, view) => {
    const parts = new URLSearchParams({ scene: name, t: view.t });
    for (const engine of view.engines) parts.append("engine", engine);
    return `#${parts}`;
  };

  /** Puts the link into the address bar, and on the clipboard where there is one. */
  const share = async (button, name, view) => {
    history.replaceState(null, "", linkTo(name, view));
    let said = "In the address bar";
    try {
      await navigator.clipboard.writeText(location.href);
      said = "Copied";
    } catch { /* without leave, or over plain HTTP, there is no clipboard */ }
    const before = button.textContent;
    button.textContent = said;
    setTimeout(() => { button.textContent = before; }, 1500);
  };

  const show = (name, view = {}) => {
    const scene = scenes.find((one) => one.dataset.scene === name);
    if (scene && scene === open) replay?.look(view);
    if (!scene || scene === open) return scene;
    if (open) {
      open.classList.remove("open");
      replay?.close();
    }
    for (const [of, link] of links) {
      if (of === name) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    const link = links.get(name);
    const list = link.closest("ul");
    // Not scrollIntoView: that would move the page, too.
    const top = link.offsetTop - list.offsetTop;
    if (top < list.scrollTop || top > list.scrollTop + list.clientHeight - 30) list.scrollTop = top - 40;
    scene.classList.add("open");
    open = scene;
    const element = scene.querySelector("[data-replay]");
    replay = element && window.Ghostball?.mountReplay
      ? replayIn(element, view, { share: (button, at) => share(button, name, at) })
      : null;
    update();
    return scene;
  };

  const shown = () => [...links.keys()].filter((name) => !links.get(name).parentElement.hidden);

  const update = () => {
    const names = shown();
    const at = open ? names.indexOf(open.dataset.scene) : -1;
    for (const button of steps) {
      const to = at + Number(button.dataset.step);
      button.disabled = at < 0 ? names.length === 0 : to < 0 || to >= names.length;
    }
    found.textContent = `${names.length} of ${links.size} scenes`;
  };

  // A link to a scene gives it the focus; from there, too, the keys of its replay work.
  for (const scene of scenes) {
    scene.addEventListener("keydown", (event) => {
      if (event.target === scene && scene === open) replay?.key(event);
    });
  }

  const follow = () => {
    const wanted = asked();
    const scene = wanted && show(wanted.name, wanted.view);
    if (!scene) return;
    scene.scrollIntoView();
    scene.focus({ preventScroll: true });
  };

  filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const [name, link] of links) {
      const title = document.getElementById(PREFIX.slice(1) + name).querySelector(".lead").textContent;
      const text = `${name} ${link.dataset.words} ${title}`.toLowerCase();
      link.parentElement.hidden = !words.every((word) => text.includes(word));
    }
    update();
  });
  filter.addEventListener("keydown", (event) => {
    const first = shown()[0];
    if (event.key === "Enter" && first) location.hash = PREFIX + first;
  });
  for (const button of steps) {
    button.addEventListener("click", () => {
      const names = shown();
      const at = open ? names.indexOf(open.dataset.scene) : -1;
      const name = names[at < 0 ? 0 : at + Number(button.dataset.step)];
      if (!name) return;
      // The button keeps the focus, so that one can continue stepping.
      history.replaceState(null, "", PREFIX + name);
      show(name);
    });
  }
  window.addEventListener("hashchange", follow);
  // Where no script runs, they lead to the scene alone.
  for (const link of document.querySelectorAll("a[data-view]")) link.href = link.dataset.view;

  if (navigator.clipboard) {
    for (const button of document.querySelectorAll(".copy")) {
      button.hidden = false;
      button.addEventListener("click", async () => {
        await navigator.clipboard.writeText(button.dataset.copy);
        button.textContent = "Copied";
        setTimeout(() => { button.textContent = "Copy"; }, 1500);
      });
    }
  }

  let folded = [];
  window.addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const one of folded) one.open = true;
  });
  window.addEventListener("afterprint", () => {
    for (const one of folded) one.open = false;
    folded = [];
  });

  // A link to what is folded, or to something in it, unfolds it.
  const unfold = () => {
    const target = location.hash && document.getElementById(location.hash.slice(1));
    if (!target) return;
    for (let one = target.closest("details"); one; one = one.parentElement.closest("details")) one.open = true;
  };
  window.addEventListener("hashchange", unfold);

  document.querySelector(".picker").hidden = false;
  if (scenes.length) show(scenes[0].dataset.scene);
  update();
  follow();
  unfold();

  // Tables that sort: by size, the least first, and what has no value last; else by their text.
  for (const table of document.querySelectorAll("table.sortable")) {
    const body = table.tBodies[0];
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const button = head.querySelector("button");
      if (!button) return;
      button.hidden = false;
      const size = (row) => {
        const { textContent, dataset: { value } } = row.cells[column];
        if (value === undefined) return textContent;
        return value === "" ? Infinity : Number(value);
      };
      button.addEventListener("click", () => {
        const rows = [...body.rows].map((row) => [size(row), row]);
        rows.sort(([one], [other]) => (one > other) - (one < other));
        body.append(...rows.map(([, row]) => row));
        for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", "ascending");
      });
    });
  }
})();
