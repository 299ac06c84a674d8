"use strict";
const PHASES = page.phases;
const dialog = document.getElementById("detail");

// A picture with its name; a click, or Enter, shows it large and small again.
function frameOf(title, picture, caption) {
  const turn = (event) => event.currentTarget.classList.toggle("large");
  return make("figure", { class: "frame", tabindex: 0, title: "larger or smaller", onclick: turn, onkeydown: (event) => { if (event.key === "Enter") turn(event); } },
    make("b", {}, title), picture, make("figcaption", {}, caption));
}

// The film strip of an attempt: what the camera saw, what the networks made of it, and how it was.
function film(item) {
  const strip = make("div", { class: item.wrist ? "strip-of-film" : "strip-of-film three" });
  if (item.mask === undefined) return strip;
  const box = crop(item), whole = [0, 0, WIDTH, HEIGHT];
  const bound = item.th === null || item.th === undefined ? "no threshold" : `threshold ${item.th.toFixed(2)}`;
  if (item.overview) strip.append(frameOf("Overview", make("img", { src: item.overview, alt: "the cell at the grasp" }), item.moment));
  if (item.gripper) strip.append(frameOf("Gripper", make("img", { src: item.gripper, alt: "the gripper at the part" }), "At the same moment, from beside the jaws."));
  const others = outlined((item.others || []).join(""), "others");
  if (item.wrist) strip.append(frameOf("Wrist camera", drawing(item, whole, "wrist camera", [pictured(item), outlined(item.mask, "mask"), outlined(item.model, "model")]), "At the look. Orange: the mask decided upon. Cyan: the model at the estimated pose."));
  strip.append(
    frameOf("1 Detection", drawing(item, box, "detection", [pictured(item), others, outlined(item.mask, "mask")]), "The detected mask; grey: other detections."),
    frameOf("2 Projection", drawing(item, box, "projection", [pictured(item), outlined(item.model, "model filled")]), `The model at the estimated pose; v = ${decimal(item.v, 2)} of it is in the picture.`),
    frameOf("3 Overlap", overlap(item, box, "overlap"), `Green: both; c = ${decimal(item.c, 2)} of what is coloured. Method's u = ${decimal(item.u, 2)}, ${bound}.`),
  );
  if (item.truth) strip.append(frameOf("The truth", drawing(item, box, "true pose", [pictured(item), outlined(item.model, "model"), outlined(item.truth, "truth")]), `Dashed green: the true pose, ${millimetres(item.err)} from the estimate (cyan). No method sees it.`));
  return strip;
}

function facts(experiment, item) {
  const rows = [
    ["outcome", item.out], ["u, threshold", `${decimal(item.u, 3)}, ${decimal(item.th, 3)}`],
    ["MaskVal's c, v", `${decimal(item.c, 3)}, ${decimal(item.v, 3)}`], ["pose error (MDD)", millimetres(item.err)],
    ["part of the belt", item.part === null || item.part === undefined ? "none: false detection" : `${item.part}, ${(100 * item.vis).toFixed(0)} % visible`],
    ["time", `${item.b.toFixed(1)} to ${item.z.toFixed(1)} s, slot ${item.s}`],
  ];
  if (item.n !== null) rows.push(["decision", `frame ${item.f}, detection ${item.d}: grasp`], ["grasp", item.grasp || "none within reach"], ["came as far as", item.state],
    ["force", item.force === null ? "no contact stopped it" : `${item.force.toFixed(0)} N on the ${item.touch}`]);
  const noise = experiment.noise.map(([name, value]) => `${name} ${value}`).join(", ");
  return make("div", {}, make("dl", {}, ...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)])),
    noise ? make("details", { class: "small" }, make("summary", {}, `Error model of world ${experiment.w}`), noise) : null);
}

const kindOf = (outcome) => (outcome === null ? "time-out" : outcome === "placed" ? "placed" : ["void", "unreachable"].includes(outcome) ? "cost" : "failed");

function timeline(experiment, item) {
  const end = Math.max(...experiment.slots.map((slot) => slot[1]), ...experiment.phases.map((phase) => phase[0]), 1);
  const placed = (from, to) => `left: ${100 * from / end}%; width: ${100 * (to - from) / end}%`;
  const line = make("div", { class: "timeline" });
  experiment.phases.forEach(([begin, phase], place) => {
    const until = place + 1 < experiment.phases.length ? experiment.phases[place + 1][0] : end;
    line.append(make("span", { class: `phase phase${phase}`, style: placed(begin, until), title: `${PHASES[phase]}, ${begin.toFixed(1)} to ${until.toFixed(1)} s` }));
  });
  experiment.slots.forEach(([begin, until, outcome], slot) => {
    const own = experiment.items.filter((one) => one.s === slot);
    const last = own[own.length - 1];
    const label = `slot ${slot}: ${outcome || "time-out"}, ${(until - begin).toFixed(1)} s`;
    line.append(make("button", { type: "button", class: `slot ${kindOf(outcome)}`, style: placed(begin, until), title: label, "aria-label": label, onclick: () => { if (last) location.hash = addressOf(experiment, last); } }, String(slot)));
  });
  const step = [5, 10, 20, 50, 100].find((size) => end / size <= 8) || 200;
  for (let tick = 0; tick < 0.96 * end; tick += step) line.append(make("span", { class: "tick", style: `left: ${100 * tick / end}%` }, `${tick} s`));
  if (item) line.append(make("span", { class: "here", style: placed(item.b, item.z) }));
  const key = make("p", { class: "key" }, ...PHASES.map((name, phase) => make("span", {}, make("i", { class: `phase${phase}` }), name)));
  return make("div", {}, line, key);
}

function command(text) {
  const code = make("code", { tabindex: 0 }, text);
  const copy = () => { getSelection().selectAllChildren(code); if (navigator.clipboard) navigator.clipboard.writeText(text).catch(() => {}); };
  return make("div", {}, code, make("button", { type: "button", onclick: copy }, "Copy"));
}

function openItem(experiment, item) {
  const shown = list.shown.findIndex((entry) => entry.item === item);
  const go = (place) => () => { const to = list.shown[place]; if (to) location.hash = addressOf(to.experiment, to.item); };
  const which = item.n === null ? `slot ${item.s}` : `attempt ${item.n}`;
  const replay = item.n === null ? experiment.cmd : `${experiment.cmd} --attempt ${item.n}`;
  const hasPart = item.part !== null && item.part !== undefined;
  show(`${experiment.o} · ${nameAndRun(experiment)} · experiment ${experiment.e} · ${which}`, make("span", { class: `badge ${item.k}` }, item.out), shown < 0 ? [] : [["← previous", go(shown - 1)], ["next →", go(shown + 1)]],
    make("p", { class: "why" }, item.why), film(item),
    item.mask !== undefined && !item.truth ? make("p", { class: "small" }, `No pictures of this one: ${runOf(experiment).pictured} report --pictures N makes more.`) : null,
    make("div", { class: "columns" }, make("div", {}, make("h3", {}, "Facts"), facts(experiment, item)),
      make("div", {}, make("h3", {}, "The same part under every method"), hasPart ? everyMethod(experiment, item.part) : make("p", {}, "No part is shown by the detection."))),
    make("h3", {}, "The experiment"), timeline(experiment, item), make("h3", {}, "Show it again: a video, or the experiment as a page in 3D"), command(replay), command(`${experiment.cmd} --out cell.html`));
}

function openPart(experiment, part) {
  const others = companions(experiment);
  show(`${experiment.o} · experiment ${experiment.e} · part ${part}`, null, [], everyMethod(experiment, part),
    ...others.flatMap((one) => {
      const item = one.items.filter((each) => each.part === part)[0];
      return [make("h3", {}, nameAndRun(one)), item ? make("p", { class: "small" }, item.why) : null, item ? film(item) : make("p", { class: "small" }, "No attempt on this part."), timeline(one, item)];
    }));
}

function show(title, badge, steps, ...content) {
  const bar = make("div", { class: "bar" }, make("h2", { id: "detail-title" }, title), badge,
    ...steps.map(([text, go]) => make("button", { type: "button", onclick: go }, text)), make("button", { type: "button", id: "close", onclick: () => dialog.close() }, "Close"));
  dialog.replaceChildren(bar, make("div", { class: "inner" }, ...content));
  if (!dialog.open) dialog.showModal();
  dialog.scrollTop = 0;
}

// Opens what the address names; an address of a section closes what is open.
function follow() {
  const message = document.getElementById("message");
  message.hidden = true;
  if (!location.hash.includes("/")) { if (dialog.open) dialog.close(); return; }
  const found = resolve(location.hash);
  if (found === null) {
    message.textContent = `This page has nothing at ${decoded(location.hash)}.`;
    message.hidden = false;
  } else if (found.item) openItem(found.experiment, found.item);
  else openPart(found.experiment, found.part);
}

dialog.addEventListener("close", () => {
  if (!location.hash.includes("/")) return;
  const address = location.hash;
  history.replaceState(null, "", location.pathname + location.search);
  const row = [...document.querySelectorAll("#list tbody tr")].find((one) => one.dataset.address === address);
  if (row) row.focus();
});
dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
document.addEventListener("keydown", (event) => {
  if (!dialog.open || event.target.matches("input, select")) return;
  const label = { ArrowLeft: "← previous", ArrowRight: "next →" }[event.key];
  const button = label && [...dialog.querySelectorAll(".bar button")].find((one) => one.textContent === label);
  if (button) button.click();
});
addEventListener("hashchange", follow);
buildList();
buildOutcomes();
buildGrids();
follow();
