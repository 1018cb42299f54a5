"use strict";

// What-if: the budget as a function of the sizes of its sources. The formulas, and why
// they are exact, stand in budget/studies/what_if.py; all numbers are in printed units.

const LOWEST = -41;   // place of a slider at which its source is left out
const HIGHEST = 40;   // at which it is ten times as large; 0 is as it is
const DECIMAL = /^\+?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

// What the scripts say in the language of the page; none are there in English.
const SAID = new Map(Object.entries(JSON.parse(document.getElementById("page-words")?.textContent ?? "{}")));

/** A template in the language of the page, with its parts; budget/report/page.py finds it by this name. */
function word(text, parts = {}) {
  return (SAID.get(text) ?? text).replace(/\{(\w+)\}/g, (_, name) => parts[name]);
}

/** Mark a constant; `word` says it where it is shown. */
function term(text) {
  return text;
}

/** The factor that a place of a slider stands for: a tenth to ten times, or 0. */
function factorAt(place) {
  return place <= LOWEST ? 0 : 10 ** (place / HIGHEST);
}

/** The place of a slider nearest to a factor. */
function placeOf(factor) {
  if (factor < factorAt(LOWEST + 1) / 2) return LOWEST;
  const place = Math.round(HIGHEST * Math.log10(factor));
  return Math.min(HIGHEST, Math.max(LOWEST + 1, place));
}

// Squared sines at the middles of equal parts of a quarter turn.
const TURN = Array.from({ length: 512 }, (_, i) => Math.sin((i + 0.5) * Math.PI / 1024) ** 2);

/**
 * The radius of the circle that a plane normal vector of principal variances a >= b lies in
 * with a probability: 1 - P is the mean of exp(-R^2 / 2 (a cos^2 t + b sin^2 t)) over all
 * directions t. To 1e-6 for every ellipse from a coverage of 10 % on; budget/methods/radius.py.
 */
function radiusOf(coverage, a, b) {
  if (!(a > 0)) return 0;
  const across = TURN.map((part) => 2 * (1 - part + part * b / a));
  let [low, high] = [0, Math.sqrt(-2 * Math.log1p(-coverage))];
  for (let i = 0; i < 45; i++) {
    const middle = (low + high) / 2;
    const outside = across.reduce((sum, part) => sum + Math.exp(-middle * middle / part), 0) / TURN.length;
    if (outside > 1 - coverage) low = middle;
    else high = middle;
  }
  return Math.sqrt(a) * (low + high) / 2;
}

/** A sum over sources and their products of one output: each source alone, and all together. */
function addUp({ first, second, pairs }, k, squares, place) {
  const alone = squares.map((square, g) => square * first[g][k] + square * square * second[g][k]);
  let all = alone.reduce((sum, part) => sum + part, 0);
  for (const pair of pairs) {
    const [g, h] = pair.sources.map((name) => place.get(name));
    all += squares[g] * squares[h] * pair.variance[k];
  }
  return { alone, all };
}

/** The budget with every source multiplied: a row for each output, a line a sensor. */
function evaluate(model, factors) {
  const outputs = model.outputs.map((_, k) => evaluateOutput(model, factors, k));
  return { outputs, sensors: judge(model, outputs, factors.some((factor) => factor !== 1)) };
}

/** One output with every source multiplied. */
function evaluateOutput(model, factors, k) {
  const squares = factors.map((factor) => factor * factor);
  const place = new Map(model.sources.map((source, g) => [source.name, g]));
  const output = model.outputs[k];
  const mean = squares.reduce((sum, square, g) => sum + square * model.mean[g][k], output.value);
  const { alone, all: variance } = addUp(model, k, squares, place);
  const bent = output.length === null ? null : model.ellipse.map((part) => addUp(part, output.length, squares, place).all);
  const [more, ...turned] = output.added;
  const atTop = endOf(output, mean, variance + more, bent && bent.map((part, i) => part + turned[i])).utilisation;
  return {
    mean, ...endOf(output, mean, variance, bent), atTop,
    shares: alone.map((part) => (variance > 0 ? part / variance : 0)),
  };
}

/** The interval of an output and the part of its limit, from its variance and, of a length, D/2 and W. */
function endOf(output, mean, variance, bent) {
  const u = Math.sqrt(Math.max(variance, 0));
  let expanded = output.factor * u;
  if (bent) {
    const half = Math.min(Math.hypot(...bent), variance / 2);
    expanded = output.factor * radiusOf(output.coverage, variance / 2 + half, variance / 2 - half);
  }
  const middle = mean + output.shift * u;
  const largest = Math.max(Math.abs(middle - expanded), Math.abs(middle + expanded));
  return { u, expanded, largest, utilisation: output.limit === null ? null : largest / output.limit };
}

const SMALL_SHARE = 0.01;  // of the variance, from which a source is named
const NO_SHARE = 1e-3;  // below which it changes nothing
const ALIKE = 1e-6;   // relative difference of quantities that count as equal

/** A number without the last digits, which the rounding of doubles decides. */
function settled(value) {
  return Number(value.toPrecision(12));
}

/** Outputs of one sensor by name: 'gyro bias x, y, z'; all six axes are every axis; of a mission by their titles. */
function joinOutputs(model, places) {
  const groups = new Map();
  const titles = [];
  for (const k of places) {
    const { group, axis, title, is_timed: isTimed } = model.outputs[k];
    if (isTimed) titles.push(title);
    else groups.set(group, [...(groups.get(group) || []), axis]);
  }
  return [...[...groups].map(([group, axes]) => `${group} ${axesOf(axes)}`), ...titles].join(word("; "));
}

function axesOf(axes) {
  return axes.length === 6 ? word("(every axis)") : axes.join(word(", "));
}

const VERDICTS = {
  meets: term("MEETS"), meets_if: term("MEETS IF"), predicted: term("PREDICTED"),
  undecided: term("UNDECIDED"), undecidable: term("UNDECIDABLE"), fails: term("FAILS"),
};

/** The verdict at a utilisation, and at that with missing lines at their ceilings: _verdict of budget/studies/what_if.py. */
function verdictOf(sensor, utilisation, atTop) {
  const [low, high] = sensor.doubt.map((part) => settled(part * utilisation));
  let given = settled(utilisation) <= 1 ? "meets" : "fails";
  if (low <= 1 && high > 1) given = "undecided";
  if (sensor.saturates) given = "fails";
  if (given !== "fails" && (sensor.is_open || !(settled(atTop) <= 1))) return "undecidable";
  return given === "meets" && sensor.conditions.length ? "meets_if" : given;
}

/** The verdict on each sensor of which something is required; of ties all are named. That of the unchanged device is its own. */
function judge(model, rows, isChanged) {
  const verdicts = [];
  for (const sensor of model.sensors) {
    const own = model.outputs.map((output, k) => k).filter((k) =>
      rows[k].utilisation !== null && model.outputs[k].sensor === sensor.name);
    if (!own.length) continue;
    const used = own.map((k) => rows[k].utilisation);
    const top = used.some(Number.isNaN) ? Infinity : Math.max(...used);
    const all = own.filter((k) => !(rows[k].utilisation < top * (1 - ALIKE)));
    const worst = all[0];
    const utilisation = rows[worst].utilisation;
    const isOwn = sensor.verdict === "predicted" || !isChanged;
    const verdict = (isOwn && VERDICTS[sensor.verdict])
      || VERDICTS[verdictOf(sensor, utilisation, Math.max(...own.map((k) => rows[k].atTop)))];
    verdicts.push({
      name: sensor.name, title: sensor.title, worst, all, utilisation, verdict,
      missing: sensor.missing, conditions: sensor.conditions,
    });
  }
  return verdicts;
}

/**
 * Up to what factor on one source, the others as they are, all limits that it decides are kept:
 * one_at_a_time of budget/studies/what_if.py. Infinity where any up to the most will do; null where
 * none does, with the outputs that the others take beyond their limits.
 */
function seek(model, factors, g) {
  const { decides } = model.sources[g];
  const judged = model.outputs.map((_, k) => k).filter((k) =>
    model.outputs[k].limit !== null && decides.includes(model.outputs[k].sensor));
  const at = (factor) => factors.map((own, h) => (h === g ? factor : own));
  const beyond = (factor) => judged.filter((k) =>
    !(settled(evaluateOutput(model, at(factor), k).utilisation) <= 1));
  const saturated = model.sensors.filter(({ name, saturates }) => saturates && decides.includes(name));
  const others = beyond(0);
  if (saturated.length || others.length) {
    const shares = others.map((k) => evaluateOutput(model, at(0), k).shares);
    return { factor: null, saturated, others, causes: [...new Set(shares.map((own) => own.indexOf(Math.max(...own))))] };
  }
  if (!beyond(model.most).length) return { factor: Infinity };
  let [low, high] = [0, model.most];
  for (let i = 0; i < 200 && settled(low) !== settled(high); i++) {
    const middle = low > 0 ? Math.sqrt(low * high) : high / 1024;
    if (beyond(middle).length) high = middle;
    else low = middle;
  }
  return { factor: low };
}

/** A number with so many digits, rounded down: of the most that will do, as print_two_down of budget/report/tables.py. */
function roundDown(value, digits = 2) {
  if (!(value > 0)) return 0;
  const step = 10 ** (Math.floor(Math.log10(settled(value))) + 1 - digits);
  return Number((Math.floor(settled(value / step)) * step).toPrecision(digits));
}

/** A number to four significant digits, as people write it. */
function fourDigits(value, resolution = 0) {
  if (Math.abs(value) <= resolution || value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return signed(value.toFixed(decimalsOf(size)));
  return powerOfTen(value, 3);
}

/** How many decimals four significant digits of a number have. */
function decimalsOf(value) {
  if (value === 0) return 0;
  return Math.max(0, 3 - Math.floor(Math.log10(Number(Math.abs(value).toPrecision(4)))));
}

/** A number rounded to its digit at 10 ** place, halves up: budget/report/tables.py. */
function roundAt(value, place) {
  const [mantissa, exponent] = Math.abs(value).toExponential(11).split("e");
  const digits = BigInt(mantissa.replace(".", ""));
  const shift = place - (Number(exponent) - 11);
  const size = 10n ** BigInt(Math.abs(shift));
  const kept = shift > 0 ? (2n * digits + size) / (2n * size) : digits * size;
  const sign = value < 0 && kept > 0n ? "-" : "";
  if (place >= 0) return `${sign}${kept * 10n ** BigInt(place)}`;
  const text = kept.toString().padStart(1 - place, "0");
  return `${sign}${text.slice(0, place)}.${text.slice(place)}`;
}

/** The place of the second digit of an uncertainty, after rounding. */
function lastPlace(u) {
  const place = Number(u.toExponential(11).split("e")[1]) - 1;
  return Number(roundAt(u, place)) >= 99.5 * 10 ** place ? place + 1 : place;
}

/**
 * A number to the last of the two digits of its u; where it is long, with an exponent. Beside a limit with as
 * many digits more as tell on which side of it it is.
 */
function likeUncertainty(value, u, resolution, limit = null) {
  if (u <= resolution) return fourDigits(value, resolution);
  const side = (number) => Math.sign(settled(number) - settled(limit));
  const first = lastPlace(u);
  const place = limit === null ? first : [0, 1, 2, 3, 4].map((more) => first - more)
    .find((each) => side(Number(roundAt(value, each))) === side(value)) ?? first;
  const text = roundAt(value, place);
  const size = Number(text) === 0 ? place : Math.floor(Math.log10(Math.abs(Number(text))));
  if (size >= -4 && size < 7) return signed(text);
  return Number(text) === 0 ? "0" : powerOfTen(Number(text), Math.max(0, size - place));
}

/** A number with so many decimals, and a power of ten. */
function powerOfTen(value, decimals) {
  const [mantissa, exponent] = value.toExponential(decimals).split("e");
  const digits = [...exponent.replace("+", "")].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);
  return `${signed(mantissa)} × 10${digits.join("")}`;
}

/** The title of a source; without its sensor beside an output of the same one. */
function shortTitle(model, source, output) {
  const sensor = model.sensors.find(({ name }) => name === source.owner && name === output.sensor);
  return sensor && source.title.startsWith(sensor.title) ? source.title.slice(sensor.title.length).trim() : source.title;
}

function signed(text) {
  return text.replace("-", "\u2212");
}

/** A share of the variance, as print_share of budget/report/tables.py has it. */
function shareOf(part) {
  const share = settled(part);
  if (Math.abs(share) < 1e-20) return "0 %";
  if (share > 0 && share < 1e-3) return "<0.1 %";
  const text = roundAt(100 * share, Math.abs(share) < 0.01 ? -1 : 0);
  return text === "100" && share < 1 - 1e-9 ? ">99 %" : `${signed(text)} %`;
}

/** A part of a limit in three digits, near it in as many as tell the side, as print_utilisation there has it. */
function perCent(part) {
  const used = settled(part);
  if (used === 1) return "100 %";
  if (used === 0) return "0 %";
  if (Math.abs(used - 1) >= 0.01) return `${roundAt(100 * used, lastPlace(10 * used))} %`;
  const text = [1, 2, 3, 4].map((decimals) => roundAt(100 * used, -decimals)).find((each) => Number(each) !== 100);
  if (text === undefined) return used < 1 ? "<100 %" : ">100 %";
  return `${text} %`;
}

/** Make an element with attributes and what is in it; texts are set as text only. */
function make(tag, attributes = {}, ...content) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...content);
  return element;
}

/** A factor in words. */
function sizeWords(factor) {
  return factor === 1 ? word("as it is") : `× ${trimmed(fourDigits(factor))}`;
}

/** A decimal without the zeros at its end. */
function trimmed(text) {
  return text.replace(/(\.\d*?)0+(?=e|$)/, "$1").replace(/\.(?=e|$)/, "");
}

// What a file gives as one number: the maker's words beside it stay as they are.
const ONE_NUMBER = /^(\d+\.?\d*(?:e[-+]?\d+)?)( [^\d,;:]+)$/i;

/** The size that a source is shown and typed in: as the data sheet has it, else its standard uncertainty. */
function givenAs(source) {
  const [, size, unit] = ONE_NUMBER.exec(source.printed) || [];
  return unit ? { size: Number(size), unit: unit.trim(), isPrinted: true } : { size: source.u, unit: source.unit };
}

/** The unit beside a size: of a standard uncertainty that is told, and of what was measured times that. */
function unitWords({ size, unit, isPrinted }) {
  if (isPrinted) return unit;
  return unit === "1" ? (size === 1 ? "× u" : "(u)") : `${unit} (u)`;
}

const MEASURED = "calibration.result";  // of a recorded run, in the place of a prediction

/** A row of a source: its name, a slider, a field with its size, and what asks for the largest that meets. */
function makeControl(model, source, { change, finish, start, ask }) {
  const given = givenAs(source);
  const slider = make("input", {
    type: "range", min: LOWEST, max: HIGHEST, step: 1,
    "aria-label": word("{source}, times its present size", { source: source.title }),
  });
  const field = make("input", {
    type: "text", inputmode: "decimal", autocomplete: "off",
    "aria-label": given.isPrinted ? word("{source}, specification value in {unit}", { source: source.title, unit: given.unit })
      : source.name === MEASURED ? word("{source}, times its uncertainty", { source: source.title })
      : word("{source}, standard uncertainty in {unit}", { source: source.title, unit: given.unit }),
  });
  const times = make("span", { class: "times" });
  const sought = make("output", { class: "sought" });
  const button = make("button", { type: "button", "aria-label": word("What meets? {source}", { source: source.title }) }, word("What meets?"));
  const isAsked = model.outputs.some(({ limit, sensor }) => limit !== null && source.decides.includes(sensor));
  const printed = make("small", {}, source.printed ? word("given as {printed}", { printed: source.printed }) : "");
  const sizeOf = (factor) => (factor === 1 && given.isPrinted ? String(given.size) : trimmed((factor * given.size).toPrecision(4)));
  let present = 1;
  const show = (factor, kept = 1, said = "") => {
    present = factor;
    slider.value = placeOf(factor);
    field.value = sizeOf(factor);
    field.removeAttribute("aria-invalid");
    times.textContent = sizeWords(factor) + (kept === 1 ? "" : word("; kept: {size}", { size: sizeWords(kept) }));
    slider.setAttribute("aria-valuetext", [times.textContent, `${field.value} ${unitWords(given)}`].join(word(", ")));
    sought.textContent = said;
    row.classList.toggle("changed", factor !== 1);
  };
  slider.addEventListener("input", () => change(factorAt(Number(slider.value))));
  slider.addEventListener("change", finish);
  slider.addEventListener("pointerdown", start);
  slider.addEventListener("blur", start);
  button.addEventListener("click", ask);
  field.addEventListener("change", () => {
    const text = field.value.trim().replace(",", ".").replace("\u2212", "-");
    // What stands in the field is rounded: typed again it is the size that it shows.
    const typed = DECIMAL.test(text) ? Number(text) / given.size : NaN;
    const factor = [present, 1].find((own) => Number(sizeOf(own)) === Number(text)) ?? typed;
    if (!(typed >= 0 && factor <= model.most)) {
      field.setAttribute("aria-invalid", "true");
      times.textContent = typed > model.most
        ? word("expected {most} at the most, a million times its size", { most: sizeOf(model.most) })
        : word("expected a number from 0 on");
      return;
    }
    start();
    change(factor);
    finish();
  });
  const row = make("div", { class: "control" },
    make("div", { class: "name" }, source.title, printed), slider,
    make("div", { class: "size" }, field, make("span", { class: "unit" }, unitWords(given))),
    make("div", { class: "effect" }, times, ...(isAsked ? [button] : [])), sought);
  return { row, show };
}

/** Say up to what size of a source everything that it decides meets, or why nothing does. */
function soughtWords(model, source, found, result) {
  const { factor, saturated, others, causes } = found;
  const { size, unit } = givenAs(source);
  if (saturated?.length) return word("no value meets: the mission asks for more than the sensor reads");
  if (others) {
    const outputs = joinOutputs(model, others);
    const sources = causes.map((g) => model.sources[g].title).join(word(", "));
    return word("no value meets: beyond the limit without it are {outputs}, mainly by {sources}", { outputs, sources });
  }
  if (factor === Infinity) return word("any value meets, up to {most} {unit}", { most: trimmed((model.most * size).toPrecision(4)), unit });
  const [largest, times] = [roundDown(factor * size), roundDown(factor)].map(String);
  const now = result.sensors.find(({ name, verdict }) =>
    source.decides.includes(name) && ![VERDICTS.meets, VERDICTS.meets_if].includes(verdict));
  return now ? word("limits are kept up to {largest} {unit} (× {times}), verdict there: {verdict}", { largest, unit, times, verdict: word(now.verdict) })
    : word("meets up to {largest} {unit} (× {times})", { largest, unit, times });
}

/** Bars of all shares of one output, in the colours that the figures have. */
function drawShares(model, shares, bar) {
  bar.replaceChildren();
  model.sources.forEach((source, g) => {
    if (shares[g] < 0.002) return;
    const part = make("span", { title: `${source.title} ${shareOf(shares[g])}`, "data-source": source.name });
    part.style.width = `${100 * Math.min(shares[g], 1)}%`;
    const colour = model.colours[source.quantity];
    part.style.background = colour === "#000000" ? "var(--black)" : colour || "var(--muted)";
    bar.append(part);
  });
}

/** Say the verdict on each sensor, which output decides it, and what it was before: a sentence of parts each. */
function verdictWords(model, result, base, label) {
  return result.sensors.map((now, i) => {
    const was = base.sensors[i];
    let missing = "";
    if (now.verdict === VERDICTS.undecidable && now.missing.length) missing = word(", as {missing} is not given", { missing: now.missing.join(word(", ")) });
    if (now.verdict === VERDICTS.meets_if) missing = word(", {conditions}", { conditions: now.conditions.join(word("; ")) });
    const isMoved = was.verdict !== now.verdict || was.utilisation !== now.utilisation;
    const before = !isMoved ? "" : word("; {label}: {verdict}, {used}", { label, verdict: word(was.verdict), used: perCent(was.utilisation) });
    const sensor = `${now.title[0].toUpperCase()}${now.title.slice(1)}`;
    const used = `${now.missing.length ? "\u2265\u00a0" : ""}${perCent(now.utilisation)}`;
    return {
      isMoved,
      verdict: word("{sensor}: {verdict}", { sensor, verdict: word(now.verdict) }),
      rest: word("{missing}. {outputs} at {used} of its limit{before}.", { missing, outputs: joinOutputs(model, now.all), used, before }),
    };
  });
}

/** A table of all outputs before and after, and the function that fills it in. */
function makeResults(model) {
  const limited = model.outputs.some((output) => output.limit !== null);
  const head = (kind, text = "") => make("th", { scope: "col", class: kind }, text);
  const before = { expanded: head("number"), used: head("number") };
  const heads = [
    head("", word("output")), before.expanded, head("number", word("U changed")), head("number", word("mean changed")),
    ...(limited ? [before.used, head("number", word("of limit changed")), head("", word("conformity"))] : []),
    head("", word("shares of the variance")), head("", word("largest")),
  ];
  const table = make("table", { "aria-label": word("Outputs with the sources changed") },
    make("thead", {}, make("tr", {}, ...heads)));
  const bodies = new Map();
  const rows = model.outputs.map((output) => {
    const title = `${output.group} [${output.unit}]`;
    if (!bodies.has(title)) {
      bodies.set(title, make("tbody", {}, make("tr", { class: "group" },
        make("th", { colspan: heads.length, scope: "rowgroup" }, title))));
    }
    const number = (name) => make("td", { class: "number", "data-cell": name });
    const cells = {
      before: number("before"), expanded: number("expanded"), mean: number("mean"),
      usedBefore: number("usedBefore"), used: number("used"), word: make("td", { class: "outcome" }),
      bar: make("div", { class: "bar" }), largest: make("td"),
    };
    const limits = limited ? [cells.usedBefore, cells.used, cells.word] : [];
    const row = make("tr", { "data-output": output.name }, make("th", { scope: "row" }, output.axis),
      cells.before, cells.expanded, cells.mean, ...limits, make("td", {}, cells.bar), cells.largest);
    bodies.get(title).append(row);
    return { row, cells };
  });
  table.append(...bodies.values());
  const update = (result, base, label) => {
    before.expanded.textContent = word("U {label}", { label });
    before.used.textContent = word("of limit {label}", { label });
    result.outputs.forEach((now, k) => fill(now, base, k));
    joinAlike();
  };
  /** Axes of a group that read the same stand in one row. */
  const joinAlike = () => {
    const first = new Map();
    rows.forEach(({ row }, k) => {
      const { group, is_timed: isTimed } = model.outputs[k];
      const text = [group, isTimed ? k : "", ...[...row.cells].slice(1).map((cell) => cell.textContent)].join("\n");
      row.hidden = first.has(text);
      if (!row.hidden) first.set(text, []);
      first.get(text).push(k);
    });
    for (const places of first.values()) rows[places[0]].row.cells[0].textContent = axesOf(places.map((k) => model.outputs[k].axis));
  };
  const fill = (now, base, k) => {
    const { row, cells } = rows[k];
    setExpanded(cells.before, base.outputs[k], model.outputs[k]);
    setUsed(cells.usedBefore, base.outputs[k], model.outputs[k]);
    const { resolution } = model.outputs[k];
    setExpanded(cells.expanded, now, model.outputs[k]);
    set(cells.mean, likeUncertainty(now.mean, now.u, resolution), now.mean);
    setUsed(cells.used, now, model.outputs[k]);
    const beyond = now.utilisation !== null && settled(now.utilisation) > 1;
    cells.word.textContent = beyond ? word("does not conform") : "";
    row.classList.toggle("beyond", beyond);
    row.classList.toggle("changed", now.expanded !== base.outputs[k].expanded);
    drawShares(model, now.shares, cells.bar);
    const most = Math.max(...now.shares) * (1 - ALIKE);
    const largest = now.shares.findIndex((share) => share >= most);
    cells.largest.textContent = now.shares[largest] > 0
      ? `${shortTitle(model, model.sources[largest], model.outputs[k])} ${shareOf(now.shares[largest]).replace(" ", "\u00a0")}` : word("no spread");
  };
  return { table, update };
}

function set(cell, text, exact) {
  cell.textContent = text;
  cell.title = String(exact);
  cell.dataset.exact = String(exact);
}

/** A number, marked where a line that is not given would make it larger. */
function bounded(text, row, output) {
  if (!output.lower_bound) return text;
  return row.u <= output.resolution ? "?" : `\u2265 ${text}`;
}

function setExpanded(cell, row, output) {
  set(cell, bounded(likeUncertainty(row.expanded, row.u, output.resolution), row, output), row.expanded);
}

function setUsed(cell, row, output) {
  if (row.utilisation === null) cell.textContent = "\u2013";
  else set(cell, bounded(perCent(row.utilisation), row, output), row.utilisation);
}

// ---- page one --------------------------------------------------------------------------

/** What shows on page one what has become of its answer, and null as it was: headline, cards and table. */
function makeAnswer(model, asItIs) {
  const places = new Map(model.outputs.map(({ name }, k) => [name, k]));
  const rows = [...document.querySelectorAll("#answer tr[data-outputs]")]
    .map((row) => ({ row, own: row.dataset.outputs.split(" ").map((name) => places.get(name)).filter((k) => k !== undefined) }))
    .filter(({ own }) => own.length);
  const before = new Map();  // what stands in an element as long as nothing is changed
  const put = (element, ...content) => {
    if (!element) return;
    if (!before.has(element)) before.set(element, { content: [...element.childNodes], classes: element.getAttribute("class") });
    element.replaceChildren(...content);
  };
  const mark = () => make("strong", { class: "changed-mark" }, word("CHANGED"));
  return (result, words) => {
    before.forEach(({ content, classes }, element) => {
      element.replaceChildren(...content);
      if (classes === null) element.removeAttribute("class");
      else element.className = classes;
    });
    document.querySelector("#answer caption.changed-mark")?.remove();
    if (!result) return;
    const headline = document.querySelector(".verdict .word");
    const said = words.map(({ verdict }) => verdict).join(word("; "));
    if (headline) put(headline, mark(), " ", ...(said ? [said] : headline.childNodes));
    const cards = document.querySelector(".verdict .cards");
    if (cards && words.length) {
      put(cards, ...words.map(({ verdict, rest, isMoved }) => make("div", {}, make("h3", {}, verdict, ...(isMoved ? [" ", mark()] : [])), make("p", {}, rest.replace(/^(\. |。)/, "")))));
      cards.classList.add("follows");
    }
    if (rows.length) rows[0].row.closest("table").prepend(make("caption", { class: "changed-mark" }, word("CHANGED")));
    rows.forEach(({ row, own }) => answerRow(model, asItIs, result, row, own, put));
  };
}

/** Fill a row of page one in: of its outputs the one that uses most of its limit, or errs most. */
function answerRow(model, asItIs, result, row, own, put) {
  const worstOf = (outputs) => own.reduce((top, k) => {
    const [best, next] = [outputs[top], outputs[k]].map(({ utilisation, largest }) => utilisation ?? largest);
    return next > best * (1 + ALIKE) ? k : top;
  });
  const [was, k] = [worstOf(asItIs.outputs), worstOf(result.outputs)];
  const output = model.outputs[k];
  const now = result.outputs[k];
  const cell = (role) => row.querySelector(`[data-role="${role}"]`);
  const size = (one) => (output.limit === null && !output.is_timed ? one.expanded : one.largest);
  const error = cell("u95");
  // In the unit of the page: the number that it shows is that of the unchanged device.
  const unit = error && Number(error.dataset.exact) > 0 && size(asItIs.outputs[was]) > 0
    ? Number(error.dataset.exact) / size(asItIs.outputs[was]) : 1;
  const text = likeUncertainty(unit * size(now), unit * now.u, unit * output.resolution, output.limit === null ? null : unit * output.limit);
  const show = (place, changed) => {
    if (!place) return;
    // Numbers of the page are filled up to the digits of their column; its unit may stand in the head.
    const old = place.textContent.replace(/[\s\u2007\u2008]+/g, " ").trim();
    const text = old.endsWith("%") ? changed : changed.replace(/ %$/, "");
    if (text === old) return;
    put(place, text, make("small", {}, word("was {old}", { old })));
    place.classList.add("moved");
  };
  show(error, bounded(text, now, output));
  if (now.utilisation !== null) {
    show(cell("used"), bounded(perCent(now.utilisation), now, output));
    put(row.cells[0], ...row.cells[0].childNodes);
    for (const each of row.cells) if (each.matches(".moved, th")) each.classList.toggle("strong", settled(now.utilisation) > 1);
  }
  const shares = cell("shares");
  if (!shares || result.outputs[k].shares.every((share, g) => share === asItIs.outputs[was].shares[g])) return;
  const bar = make("span", { class: "parts", "aria-hidden": "true" });
  drawShares(model, now.shares, bar);
  const ranked = model.sources.map((source, g) => ({ source, share: now.shares[g] }))
    .filter(({ share }) => share >= SMALL_SHARE).sort((a, b) => b.share - a.share).slice(0, 3);
  const rest = 1 - ranked.reduce((sum, { share }) => sum + share, 0);
  put(shares, bar, [
    ...ranked.map(({ source, share }) => `${shortTitle(model, source, output)} ${shareOf(share)}`),
    ...(rest >= NO_SHARE ? [word("rest {rest}", { rest: shareOf(rest) })] : []),
  ].join(word(", ")));
}

// ---- what is changed: in words, as a file with its command, in the address, on paper ----

/** Each source that is changed, with its factor. */
function changesOf(model, factors) {
  return model.sources.map((source, g) => ({ source, factor: factors[g] }))
    .filter(({ factor }) => factor !== 1);
}

/** Changes in words: 'gyro bias repeatability × 0.4'. */
function changeWords(model, factors) {
  return changesOf(model, factors)
    .map(({ source, factor }) => `${source.title} ${sizeWords(factor)}`).join(word(", "));
}

/** A number as files have it, without the digits that rounding decides. */
function written(value) {
  return String(settled(value));
}

const MARK = "\u0002";  // on both sides of a size; no text of a device can hold it

/** The device file with the lines of changed sources multiplied, and what is not in it. */
function changedDevice(model, factors) {
  const left = new Map(changesOf(model, factors).map(({ source, factor }) => [source.name, factor]));
  const present = new Map(left);
  let owner = "";
  const lines = model.device.split("\n").map((line) => {
    owner = /^(\w+):$/.exec(line)?.[1] ?? owner;
    if (!line.includes(MARK)) return line;
    const name = `${owner}.${/^ *(\w+):/.exec(line)[1]}`;
    left.delete(name);
    return line.split(MARK).map((part, i) =>
      (i % 2 ? written(part * (present.get(name) ?? 1)) : part)).join("");
  });
  return { text: lines.join("\n"), elsewhere: changesOf(model, factors).filter(({ source }) => left.has(source.name)) };
}

/** A word that a shell takes as it stands. */
function shellWord(text) {
  return `'${text.replaceAll("'", "'\\''")}'`;
}

/** The command that analyses the changed device: by --set where every line is one number. */
function changedCommand(model, factors) {
  const sets = changesOf(model, factors).map(({ source, factor }) => {
    const [, size, unit] = ONE_NUMBER.exec(source.printed) || [];
    return unit && shellWord(`${source.name}=${written(size * factor)}${unit}`);
  });
  if (sets.includes(undefined)) return model.command_of_file;
  return [model.command, ...sets.map((set) => `--set ${set}`)].join(" ") + model.operands;
}

/** Fields with the changed device and its command, and what fills them in. */
function makeHandOut(model) {
  const field = (label, rows) => {
    const area = make("textarea", { readonly: "", rows, spellcheck: "false" });
    area.addEventListener("focus", () => area.select());
    return { area, block: make("p", {}, make("label", {}, label, area)) };
  };
  const command = field(word("Command"), 3);
  const device = field(word("Device file, changed.yaml"), 12);
  const words = make("p", {});
  const place = make("details", { class: "hand-out" },
    make("summary", {}, word("The changed device as a file, with its command")),
    words, ...(model.command ? [command.block] : []), ...(model.device ? [device.block] : []));
  const update = (factors) => {
    const { text, elsewhere } = changedDevice(model, factors);
    const said = changeWords(model, factors);
    const rest = changeWords({ sources: elsewhere.map(({ source }) => source) }, elsewhere.map(({ factor }) => factor));
    words.textContent = said ? word("Changed: {said}.", { said }) : word("Nothing is changed.");
    const isMeasured = changesOf(model, factors).some(({ source }) => source.name === MEASURED);
    if (isMeasured) words.append(word(" What a run measured is in no file: another run would have to measure it."));
    else if (!model.device) words.append(word(" No file says all of this device: it is changed by --set."));
    else if (rest) words.append(word(" Not a specification of the device, change it where it stands: {rest}.", { rest }));
    device.area.value = (said ? `${word("# Changed by what-if: {said}", { said })}\n` : "") + text;
    const isElsewhere = elsewhere.length && model.device;
    command.area.value = isMeasured ? word("No command says it.")
      : (isElsewhere ? model.command_of_file : changedCommand(model, factors))
      || word("No command says it: a changed specification has several numbers, or is none of the device. Change it in its file.");
  };
  return { place, update };
}

const ADDRESS = "#what-if?";
const LONGEST = 4000;  // characters of an address that are looked at

/** Both scenarios as the end of an address; '' where nothing is changed. */
function toAddress(model, factors, kept) {
  const search = new URLSearchParams();
  for (const [before, scenario] of [["", factors], ["kept.", kept || []]]) {
    model.sources.forEach(({ name }, g) => {
      if ((scenario[g] ?? 1) !== 1) search.set(before + name, String(scenario[g]));
    });
  }
  const text = search.toString();
  return text && ADDRESS + text;
}

/** A text of anybody, short and in plain letters. */
function quote(text) {
  const plain = JSON.stringify(text.slice(0, 40)).replace(/[^\x20-\x7e]/g, (sign) =>
    `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);
  return text.length > 40 ? word("{plain} and {n} characters more", { plain, n: text.length - 40 }) : plain;
}

/** Read the end of an address: both scenarios, or in words what is wrong with it. */
function fromAddress(model, text) {
  const place = new Map(model.sources.map(({ name }, g) => [name, g]));
  const [factors, kept] = [0, 1].map(() => model.sources.map(() => 1));
  const refuse = (what) => ({ wrong: word("The changes in the address are not taken: {what}.", { what }) });
  if (text.length > LONGEST) {
    return refuse(word("they have {n} characters, {most} are allowed", { n: text.length, most: LONGEST }));
  }
  const seen = new Set();
  for (const [key, value] of new URLSearchParams(text)) {
    const isKept = key.startsWith("kept.");
    const g = place.get(isKept ? key.slice("kept.".length) : key);
    if (g === undefined) return refuse(word("{key} is no source of this report", { key: quote(key) }));
    if (seen.has(key)) return refuse(word("{key} stands there twice", { key: quote(key) }));
    if (!DECIMAL.test(value) || !(Number(value) <= model.most)) {
      return refuse(word("{key} is {value}, expected a number from 0 to a million, times its size",
        { key: quote(key), value: quote(value) }));
    }
    seen.add(key);
    (isKept ? kept : factors)[g] = Number(value);
  }
  return { factors, kept: kept.every((factor) => factor === 1) ? null : kept };
}

const TITLE = document.title;

/** What says on the screen and on every printed page that this is not the report, while anything is changed. */
function makeBanner(reset) {
  const root = document.documentElement;
  const verdicts = make("p", { class: "verdicts" });
  const said = make("p");
  const button = make("button", { type: "button" }, word("Reset"));
  button.addEventListener("click", reset);
  const banner = make("div", { class: "stamp" },
    make("strong", { "aria-hidden": "true" }, word("CHANGED")), make("div", {}, verdicts, said), button);
  document.body.prepend(banner);
  // What sticks below it, and where links lead to, is that much lower.
  const measure = () => root.style.setProperty("--banner", `${banner.offsetHeight}px`);
  new ResizeObserver(measure).observe(banner);
  return (changes, words) => {
    const isChanged = changes !== "";
    said.textContent = isChanged ? word("CHANGED by what-if, not the report that was issued: {said}.", { said: changes }) : "";
    verdicts.textContent = isChanged ? words.join(word("; ")) : "";
    root.classList.toggle("altered", isChanged);
    measure();
    document.title = isChanged ? word("CHANGED {title}", { title: TITLE }) : TITLE;
    if (isChanged) root.style.setProperty("--running-head", JSON.stringify(word("CHANGED by what-if, not the report that was issued")));
    else root.style.removeProperty("--running-head");
  };
}

/** Set up the sliders of one model in an empty place of the page. */
function setUpWhatIf(place, model) {
  const present = model.sources.map(() => 1);
  const asItIs = evaluate(model, present);
  let factors = [...present];
  let kept = null;
  let run = null;  // what the newest entry of the history is still changed by
  const verdict = make("div", { class: "outlook" });
  const spoken = make("p", { class: "unseen", role: "status", "aria-live": "polite" });
  const wrong = make("p", { class: "wrong", role: "alert" });
  const results = makeResults(model);
  const handOut = model.device || model.command ? makeHandOut(model) : null;
  const act = (change) => () => { change(); refresh(); finish(null); };
  const button = (text, change) => {
    const made = make("button", { type: "button" }, text);
    made.addEventListener("click", act(change));
    return made;
  };
  const clear = () => { factors = [...present]; kept = null; };
  const keep = button(word("Keep to compare"), () => { kept = factors.every((factor) => factor === 1) ? null : [...factors]; });
  const forget = button(word("Forget what is kept"), () => { kept = null; keep.focus(); });
  const reset = button(word("Reset all"), clear);
  const banner = makeBanner(act(() => { clear(); document.querySelector("main").focus({ preventScroll: true }); }));
  const answer = makeAnswer(model, asItIs);
  const refresh = (sought = () => "") => {
    const label = kept ? word("kept") : word("as it is");
    const base = kept ? evaluate(model, kept) : asItIs;
    const result = evaluate(model, factors);
    const words = verdictWords(model, result, base, label);
    controls.forEach((control, g) => control.show(factors[g], kept ? kept[g] : 1, sought(g, result)));
    verdict.replaceChildren(...words.map(({ verdict: own, rest }) => make("p", {}, make("strong", {}, own), rest)));
    if (!words.length) verdict.append(make("p", {}, word("No requirement: U of every output, as it is and changed.")));
    results.update(result, base, label);
    handOut?.update(factors);
    forget.hidden = !kept;
    const told = [changeWords(model, factors), kept && word("kept to compare: {changes}", { changes: changeWords(model, kept) || word("as it is") })];
    banner(told.filter(Boolean).join(word("; ")), words.map((own) => own.verdict));
    answer(factors.some((factor) => factor !== 1) ? result : null, words);
  };
  /** Speak what has come of a change, and let Back undo it; a run of one control is one change. */
  const finish = (control) => {
    const said = verdict.textContent;
    if (spoken.textContent !== said) spoken.textContent = said;
    note(control !== null && control === run);
    run = control;
  };
  const note = (isSame) => {
    wrong.textContent = "";
    const address = toAddress(model, factors, kept) || (location.hash.startsWith(ADDRESS) ? "#what-if" : location.hash);
    if (address === location.hash) return;
    try {
      history[isSame ? "replaceState" : "pushState"]({ own: true }, "", address);
    } catch { /* a preview that has no address */ }
  };
  const restore = () => {
    run = null;
    const isOwn = history.state?.own;
    if (!location.hash.startsWith(ADDRESS)) {
      // Back at what was not changed, or a link within the page was followed: its address says again what is shown.
      if (isOwn) { clear(); refresh(); } else note(true);
      own();
      return;
    }
    const found = fromAddress(model, location.hash.slice(ADDRESS.length));
    wrong.textContent = found.wrong || "";
    ({ factors, kept } = found.wrong ? { factors: [...present], kept: null } : found);
    refresh();
    own();
    if (!isOwn) place.parentElement.scrollIntoView();
  };
  /** Mark an entry of the history as one whose address says what is changed. */
  const own = () => {
    try {
      history.replaceState({ own: true }, "");
    } catch { /* as above */ }
  };
  const controls = model.sources.map((source, g) => makeControl(model, source, {
    change: (factor) => { factors[g] = factor; refresh(); },
    finish: () => finish(g),
    start: () => { run = null; },
    ask: () => {
      const found = seek(model, factors, g);
      // To a size that the field shows, on this side of the limit.
      const { size } = givenAs(source);
      if (Number.isFinite(found.factor)) factors[g] = roundDown(found.factor * size, 4) / size;
      refresh((h, result) => (h === g ? soughtWords(model, source, found, result) : ""));
      finish(null);
    },
  }));
  const [moving, still] = [true, false].map((moves) => controls.filter((_, g) =>
    moves === asItIs.outputs.some(({ shares }) => settled(shares[g]) >= NO_SHARE)).map(({ row }) => row));
  const folded = make("details", {},
    make("summary", {}, word("{n} more, each below 0.1 % of every variance", { n: still.length })), ...still);
  place.append(
    wrong,
    verdict,
    spoken,
    make("div", { class: "controls" },
      make("p", { class: "small" },
        word("Each slider runs from 0 at the far left over a tenth to ten times the present size; the field takes the value as the data sheet gives it. "),
        word("The address of the page keeps the changes. ")),
      make("p", { class: "buttons" }, keep, " ", forget, " ", reset),
      ...moving,
      ...(still.length ? [folded] : []),
      ...(handOut ? [handOut.place] : [])),
    make("div", { class: "results scroll", tabindex: 0, role: "group", "aria-label": word("Outputs with the sources changed") }, results.table));
  place.hidden = false;
  refresh();
  restore();
  folded.open = still.some((row) => row.classList.contains("changed"));
  window.addEventListener("hashchange", restore);
}
