// The page around the replays: shows one scene at a time, found by name or by the URL fragment.
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

  // The motion of a scene is decoded only when its replay comes into view.
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

  /** A replay that is decoded once it comes into view. It can show a given view, and can be closed. */
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

  /** Reads a URL fragment: a scene and, optionally, a time and the engines to show. */
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

  /** Puts the link into the address bar and, if there is a clipboard, on the clipboard. */
  const share = async (button, name, view) => {
    history.replaceState(null, "", linkTo(name, view));
    let said = "In the address bar";
    try {
      await navigator.clipboard.writeText(location.href);
      said = "Copied";
    } catch { /* without permission, or over plain HTTP, there is no clipboard */ }
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

  // A link to a scene gives the scene the focus, so the keys of its replay work there, too.
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
  // Without a script, these links only lead to the scene.
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

  // A link to a folded part, or to an element inside, unfolds the part.
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

  // Sortable tables: smallest value first, cells without a value last; columns of text by text.
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
