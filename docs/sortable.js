// Sorts the tables in an element of the class `sortable` by a click on a head, or by the keyboard.

const UNITS = {
  fm: 1e-15, pm: 1e-12, nm: 1e-9, "µm": 1e-6, mm: 1e-3, cm: 1e-2, m: 1,
  ns: 1e-9, "µs": 1e-6, ms: 1e-3, s: 1, min: 60,
};

// "exact" and "rounding" come before all numbers, other words after them.
function valueOf(cell) {
  const text = cell.textContent.trim();
  if (text.startsWith("exact") || text.startsWith("rounding")) return 0;
  const found = text.match(/^([\d.]+(?:e[+-]?\d+)?)\s*(fm|pm|nm|µm|mm|cm|min|ms|ns|µs|m|s)?\b/);
  return found ? found[1] * (UNITS[found[2]] ?? 1) : NaN;
}

function compare(a, b) {
  const [x, y] = [valueOf(a), valueOf(b)];
  if (!isNaN(x) && !isNaN(y)) return x - y;
  if (!isNaN(x) || !isNaN(y)) return isNaN(x) ? 1 : -1;
  return a.textContent.localeCompare(b.textContent);
}

function makeSortable(table) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    button.addEventListener("click", () => {
      const direction = head.getAttribute("aria-sort") === "ascending" ? "descending" : "ascending";
      for (const other of heads) other.setAttribute("aria-sort", "none");
      head.setAttribute("aria-sort", direction);
      const sign = direction === "ascending" ? 1 : -1;
      const rows = [...table.tBodies[0].rows];
      rows.sort((a, b) => sign * compare(a.cells[column], b.cells[column]));
      table.tBodies[0].append(...rows);
    });
  });
}

document.querySelectorAll(".sortable table").forEach(makeSortable);
