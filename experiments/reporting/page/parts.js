"use strict";
const FATES = { placed: "placed", failed: "failed", both: "failed, then placed", cost: "attempts met nothing", left: "left on the belt" };
const SIGNS = { placed: "✓", failed: "✕", both: "", cost: "○", left: "" };

// What a part came to in an experiment: placed, failed, both, cost (its attempts met nothing), or left.
function fateOf(experiment, part) {
  const kinds = experiment.items.filter((item) => item.n !== null && item.part === part).map((item) => item.k);
  const placed = kinds.includes("placed"), failed = kinds.includes("failed");
  return placed && failed ? "both" : placed ? "placed" : failed ? "failed" : kinds.includes("cost") ? "cost" : "left";
}

// The experiments in which others met the same parts: of the same number, and of runs with the same seed.
function companions(experiment) {
  const run = runOf(experiment);
  return page.experiments.filter((one) => one.o === experiment.o && one.e === experiment.e && one.parts === experiment.parts &&
    runOf(one).seed === run.seed && one.failure === null);
}

function buildGrids() {
  const place = document.getElementById("grids");
  for (const [number, run] of page.runs.entries()) {
    for (const object of distinct(page.experiments.filter((one) => one.r === number).map((one) => one.o))) {
      const own = page.experiments.filter((one) => one.r === number && one.o === object && one.failure === null);
      const names = distinct(own.map(nameOf));
      const columns = names.length + (names.length > 1 ? 1 : 0);
      const grid = make("div", { class: "grid", style: `grid-template-columns: auto repeat(${columns}, max-content)` });
      grid.append(make("span"), ...names.map((name) => make("b", {}, `${name}${failedParts(own, name)}`)));
      if (names.length > 1) grid.append(make("b", {}, "methods it failed under"));
      for (const experiment of distinct(own.map((one) => one.e)).sort((a, b) => a - b)) {
        grid.append(make("span", { class: "number" }, String(experiment)));
        const here = own.filter((one) => one.e === experiment);
        for (const name of names) grid.append(stripOf(here.find((one) => nameOf(one) === name)));
        if (names.length > 1) grid.append(countsOf(here));
      }
      place.append(make("div", {}, make("h3", {}, severalRuns ? `${run.name}: ${object}` : object),
        make("p", { class: "small" }, failedUnderAll(own, names)), make("div", { class: "scroll" }, grid)));
    }
  }
}

function failedParts(own, name) {
  let failed = 0;
  for (const one of own) if (nameOf(one) === name) for (let part = 0; part < one.parts; part++) failed += ["failed", "both"].includes(fateOf(one, part));
  return ` · ${failed} failed`;
}

// How many parts every method failed on, and which they are: those that are hard in themselves.
function failedUnderAll(own, names) {
  const count = new Map();
  for (const one of own) for (let part = 0; part < one.parts; part++) {
    const key = `experiment ${one.e}, part ${part}`;
    if (["failed", "both"].includes(fateOf(one, part))) count.set(key, (count.get(key) || 0) + 1);
  }
  const by = (least) => [...count].filter(([, times]) => times >= least).map(([key]) => key);
  if (names.length < 2) return `${count.size} parts failed.`;
  const all = by(names.length);
  const told = all.length ? `: ${all.slice(0, 6).join("; ")}${all.length > 6 ? "; …" : ""}` : "";
  return `${count.size} parts failed under one method at least, ${by(2).length} under two or more, ${all.length} under every method${told}.`;
}

function stripOf(experiment) {
  const strip = make("span", { class: "strip" });
  if (!experiment) return strip;
  for (let part = 0; part < experiment.parts; part++) {
    const fate = fateOf(experiment, part);
    const label = `${nameOf(experiment)}, experiment ${experiment.e}, part ${part}: ${FATES[fate]}`;
    strip.append(make("button", { type: "button", class: `square ${fate}`, title: label, "aria-label": label, onclick: () => { location.hash = addressOfPart(experiment, part); } }, SIGNS[fate]));
  }
  return strip;
}

// Under how many methods each part of an experiment failed.
function countsOf(experiments) {
  const strip = make("span", { class: "strip" });
  for (let part = 0; part < Math.max(...experiments.map((one) => one.parts)); part++) {
    const count = experiments.filter((one) => ["failed", "both"].includes(fateOf(one, part))).length;
    strip.append(make("span", { class: `square times${Math.min(count, 3)}`, title: `part ${part} failed under ${count} of ${experiments.length} methods` }, String(count)));
  }
  return strip;
}

// What happened to a part in an experiment, in the order of time: looks at it that were decided upon, and attempts.
function historyOf(experiment, part) {
  const events = [];
  let passed = 0, bestU = null;
  for (const [frame, time, refining, slot, action, chosen, u, threshold, seen] of experiment.looks) {
    const about = chosen !== null && seen[chosen] && seen[chosen][0] === part;
    const other = seen.filter(([shown], place) => shown === part && place !== chosen);
    if (about) events.push({ time, action, u, threshold, error: seen[chosen][2], refining });
    else if (other.length) { passed += 1; for (const one of other) bestU = bestU === null ? one[1] : Math.min(bestU, one[1]); }
  }
  for (const item of experiment.items) if (item.n !== null && item.part === part) events.push({ time: item.z, item });
  return { events: events.sort((a, b) => a.time - b.time), passed, bestU };
}

// Refusals and second looks one after the other as one event, where they are many.
function merged(events) {
  const found = [];
  for (const event of events) {
    const last = found[found.length - 1];
    if (event.item || event.action === "grasp" || !last || !last.run) found.push({ ...event, run: event.action === "search" || event.action === "refine" ? [event] : null });
    else last.run.push(event);
  }
  return found.flatMap((event) => (event.run && event.run.length <= 3 ? event.run : [event]));
}

function summaryOf(events) {
  const refused = events.filter((event) => event.action === "search"), again = events.length - refused.length;
  const least = Math.min(...events.map((event) => event.u));
  const errors = events.map((event) => event.error);
  const looks = again ? ` and looked at again ${again} times` : "";
  return `${events[0].time.toFixed(1)} to ${events[events.length - 1].time.toFixed(1)} s: refused ${refused.length} times${looks}, least u ${least.toFixed(2)} (${Math.min(...errors).toFixed(1)} to ${Math.max(...errors).toFixed(1)} mm off)`;
}

function chipOf(experiment, event) {
  if (event.item) {
    const force = event.item.force === null ? "" : `, ${event.item.force.toFixed(0)} N`;
    return make("a", { class: `chip ${event.item.k}`, href: addressOf(experiment, event.item) }, `${event.time.toFixed(1)} s ${event.item.out}${force}`);
  }
  if (event.run && event.run.length > 3) return make("span", { class: "chip search" }, summaryOf(event.run));
  const bound = event.threshold === null ? "" : event.action === "search" ? ` > ${event.threshold.toFixed(2)}` : ` ≤ ${event.threshold.toFixed(2)}`;
  const what = { grasp: "grasp", refine: "look again", search: "refuse" }[event.action];
  return make("span", { class: `chip ${event.action}` }, `${event.time.toFixed(1)} s u ${decimal(event.u, 2)}${bound}: ${what} (${millimetres(event.error)} off)`);
}

// Where the methods parted: the first decision about the part, or else what came of it.
function parting(experiments, part) {
  const first = experiments.map((one) => [nameAndRun(one), historyOf(one, part).events.find((event) => event.action)]);
  const words = { grasp: "grasped it", refine: "looked at it again", search: "refused it" };
  const actions = distinct(first.map(([, event]) => (event ? event.action : "none")));
  if (experiments.length < 2) return "Only one method met this part.";
  const told = first.map(([name, event]) => (event ? `${name} ${words[event.action]} (u ${decimal(event.u, 2)}, ${millimetres(event.error)} off)` : `${name} never decided about it`));
  return `${actions.length > 1 ? "They parted at their first decision about it" : "First decisions about it"}: ${told.join("; ")}.`;
}

const nameAndRun = (experiment) => (severalRuns ? `${nameOf(experiment)} (${runOf(experiment).name})` : nameOf(experiment));

function everyMethod(experiment, part) {
  const others = companions(experiment);
  const box = make("div", {}, make("p", {}, make("b", {}, parting(others, part))));
  for (const one of others) {
    const { events, passed, bestU } = historyOf(one, part);
    const also = passed ? `seen in ${passed} other looks${bestU === null ? "" : `, least u ${bestU.toFixed(2)}`}` : null;
    const chips = make("div", { class: "chips" }, ...merged(events).map((event) => chipOf(one, event)), also ? make("span", { class: "chip" }, also) : null);
    if (!events.length && !also) chips.append(make("span", { class: "chip" }, "no look showed it"));
    box.append(make("div", { class: "who" }, make("b", {}, `${nameAndRun(one)}: ${FATES[fateOf(one, part)]}`), chips));
  }
  return box;
}
