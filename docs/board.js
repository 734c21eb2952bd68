// Sorts the board by the column whose head is pressed: what has no size comes last.
for (const table of document.querySelectorAll("table")) {
  if (!table.querySelector("td.cell")) continue;
  table.querySelectorAll("th").forEach((head, k) => {
    head.style.cursor = "pointer";
    head.title = "Sort by this column";
    head.tabIndex = 0;
    const size = row => {
      const cell = row.cells[k];
      const value = cell.dataset.size;
      return k === 0 ? cell.textContent : value ? Number(value) : Infinity;
    };
    const sort = () => {
      const body = table.tBodies[0];
      const rows = [...body.rows].sort((a, b) => (size(a) > size(b)) - (size(a) < size(b)));
      body.append(...rows);
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", event => event.key === "Enter" && sort());
  });
}
