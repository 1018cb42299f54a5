// Tables that can be sorted and searched. Without this script the page says the same.

const collator = new Intl.Collator(document.documentElement.lang, { numeric: true });

/** What a cell is sorted by: its exact number where it has one, else its text. */
function sortKey(row, column) {
  const cell = row.cells[column];
  const exact = cell.dataset.exact;
  return exact === undefined ? cell.textContent.trim() : Number(exact);
}

/** Compare two keys; numbers come before texts. */
function compareKeys(a, b) {
  if (typeof a === "number" && typeof b === "number") return a - b;
  if (typeof a === "number") return -1;
  if (typeof b === "number") return 1;
  return collator.compare(a, b);
}

/** Order rows by one column; equal ones stay as they were. 0 is the first order. */
function orderRows(rows, column, direction) {
  if (direction === 0) return rows;
  const keyed = rows.map((row) => [sortKey(row, column), row]);
  keyed.sort(([a], [b]) => direction * compareKeys(a, b));
  return keyed.map(([, row]) => row);
}

/** Give the heads of a table buttons that sort the rows within each group. */
function setUpSorting(table) {
  const groups = [...table.tBodies].map((body) =>
    [body, [...body.rows].filter((row) => !row.classList.contains("group"))]);
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    if (head.matches("td, .unit")) return;  // units beside their numbers
    const button = make("button", { type: "button", title: word("Sort") }, ...head.childNodes);
    head.replaceChildren(button);
    button.addEventListener("click", () => {
      const before = head.getAttribute("aria-sort");
      const direction = before === "ascending" ? -1 : before === "descending" ? 0 : 1;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      if (direction) head.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
      for (const [body, rows] of groups) body.append(...orderRows(rows, column, direction));
    });
  });
}

/** Show only the rows in which every word of the search stands; return how many. */
function filterRows(tables, search) {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  let shown = 0;
  let all = 0;
  for (const table of tables) {
    for (const body of table.tBodies) {
      const title = body.querySelector("tr.group");
      const rows = [...body.rows].filter((row) => row !== title);
      const about = title ? title.textContent : "";
      let found = 0;
      for (const row of rows) {
        const text = `${about} ${row.textContent}`.replace(/\s+/g, " ").replace(/\u2212/g, "-").toLowerCase();
        row.hidden = !words.every((word) => text.includes(word));
        found += row.hidden ? 0 : 1;
      }
      body.hidden = found === 0 && rows.length > 0;
      shown += found;
      all += rows.length;
    }
  }
  return { shown, all };
}

/** Let one field search tables; `/` leads to it, Escape empties it. */
function setUpSearch(place, tables) {
  const field = place.querySelector("input");
  const count = place.querySelector("output");
  const search = () => {
    const { shown, all } = filterRows(tables, field.value);
    count.textContent = field.value.trim() ? word("{shown} of {all} rows", { shown, all }) : "";
    document.body.classList.toggle("searching", Boolean(field.value.trim()));
  };
  field.addEventListener("input", search);
  document.addEventListener("keydown", (event) => {
    const typing = event.target.matches("input, textarea, select");
    if (event.key === "/" && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) {
      event.preventDefault();
      field.focus();
      field.select();
    } else if (event.key === "Escape" && event.target === field) {
      field.value = "";
      search();
    }
  });
  place.hidden = false;
}

/** On a narrow page a tap on the head of a row shows the columns that are folded below it. */
function setUpFolds(tables) {
  const narrow = matchMedia("(max-width: 40rem)");
  const rows = tables.flatMap((table) => [...table.tBodies].flatMap((body) => [...body.rows]))
    .filter((row) => [...row.querySelectorAll(".more")].some((cell) => cell.textContent));
  const fold = () => {
    tables.forEach((table) => table.classList.toggle("folds", narrow.matches));
    for (const row of rows) {
      const head = row.cells[0];
      const button = make("button", { type: "button", "aria-expanded": "false" });
      const [from, to] = narrow.matches ? [head, button] : [head.firstChild, head];
      to.replaceChildren(...from.childNodes);
      if (!narrow.matches) continue;
      head.replaceChildren(button);
      row.classList.remove("open");
      button.addEventListener("click", () =>
        button.setAttribute("aria-expanded", String(row.classList.toggle("open"))));
    }
  };
  if (narrow.matches) fold();
  narrow.addEventListener("change", fold);
}

/** Boxes that show all that is in them are no stops of the Tab key. */
function setUpStops() {
  const watch = new ResizeObserver((boxes) => boxes.forEach(({ target }) => {
    const more = target.scrollWidth > target.clientWidth || target.scrollHeight > target.clientHeight;
    target.tabIndex = more ? 0 : -1;
    target.classList.toggle("beyond-sides", target.scrollWidth > target.clientWidth);
  }));
  document.querySelectorAll("[role=group][tabindex]").forEach((box) => watch.observe(box));
}

function setUpPage() {
  document.querySelectorAll("table[data-searchable]").forEach(setUpSorting);
  // Of all tables that lie open; those behind a figure repeat what is beside them.
  const tables = [...document.querySelectorAll("table[id]")]
    .filter((table) => !table.closest("details"));
  const place = document.querySelector(".search");
  if (place) setUpSearch(place, tables);
  for (const model of document.querySelectorAll("script.what-if-model")) {
    setUpWhatIf(model.previousElementSibling, JSON.parse(model.textContent));
  }
  setUpFolds([...document.querySelectorAll("table.folded")]);
  setUpStops();
}

setUpPage();
