// Replays the run behind the row that the fragment names, beside ours.
"use strict";
(() => {
  const dataOf = (id) => JSON.parse(document.getElementById(id).textContent);
  const rows = dataOf("rows");
  const REFERENCE = "ghostball";
  const element = document.getElementById("replay");
  let open = null;
  const show = () => {
    const asked = decodeURIComponent(location.hash.slice(1));
    const row = rows[asked] ? asked : Object.keys(rows)[0];
    const { shot, says, again, page } = rows[row];
    if (open?.shot !== shot) {
      open?.mounted.destroy();
      open = { shot, mounted: window.Ghostball.mountReplay(element, dataOf(`shot-${shot}`)) };
    }
    const engines = [...new Set([REFERENCE, row])]
      .filter((one) => open.mounted.engines.includes(one));
    open.mounted.ready.then(() => open.mounted.look({ engines }));
    for (const link of document.querySelectorAll(".rows a")) {
      if (link.dataset.row === row) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    document.getElementById("what").textContent = says;
    document.getElementById("again").textContent = again;
    document.getElementById("engine").href = page;
  };
  addEventListener("hashchange", () => {
    show();
    document.getElementById("what").scrollIntoView();
  });
  show();
})();
